"""Visible boxes beside a search of each object's pixels."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from benchmarks.data.sets.tables import visible_boxes


@settings(max_examples=60, deadline=None)
@given(arrays.arrays(np.int32, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(-2, 6)))
def test_boxes_enclose_the_pixels_of_each_object(instance_map):
    ids = np.array([5, 0, 6, 9])
    for box, own in zip(visible_boxes(instance_map, ids), ids, strict=True):
        rows, columns = np.nonzero(instance_map == own)
        if len(rows) == 0:
            assert np.isnan(box).all()
        else:
            assert box.tolist() == [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
