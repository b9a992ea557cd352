"""Runs of equal pixels against numpy's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.render.rows import WIDEST, find_runs, new_lines


@settings(max_examples=200, deadline=None)
@given(width=st.sampled_from([1, 2, 31, 32, 33, 34, 64, 65, 66, 160]), seed=st.integers(0, 9999), few=st.booleans())
def test_runs_begin_where_values_change(width, seed, few):
    rng = np.random.default_rng(seed)
    changes = rng.random(width) < (0.03 if few else 0.5)
    values = np.cumsum(changes).astype(np.int32) % 3 - 1
    firsts = np.empty(width + 1, np.uint32)
    count = find_runs(values, firsts)
    expected = [0, *(np.flatnonzero(np.diff(values)) + 1), width]
    np.testing.assert_array_equal(firsts[: int(count) + 1], expected)


def test_rows_that_are_too_wide_are_refused():
    with pytest.raises(ValueError, match="width: expected at most 4096"):
        new_lines(1, WIDEST + 1)
