"""Codings against the values that went in."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from benchmarks.data.sets.channels import CODINGS, coding_of

SIDES = st.tuples(st.integers(1, 20), st.integers(1, 20))
PICTURES = st.one_of(
    SIDES.flatmap(lambda side: arrays.arrays(np.uint8, (*side, 3))),
    SIDES.flatmap(lambda side: arrays.arrays(np.uint16, side)),
)
MAPS = st.one_of(
    SIDES.flatmap(lambda side: arrays.arrays(np.int32, side)),
    SIDES.flatmap(lambda side: arrays.arrays(np.float32, (*side, 2))),
)


@settings(max_examples=50, deadline=None)
@given(st.one_of(PICTURES, MAPS))
def test_blosc2_keeps_every_bit(values):
    read = CODINGS["blosc2"].decode(CODINGS["blosc2"].encode(values))
    assert read.dtype == values.dtype
    assert read.shape == values.shape
    assert read.tobytes() == values.tobytes()


@settings(max_examples=50, deadline=None)
@given(PICTURES)
def test_png_keeps_every_bit_of_a_picture(values):
    read = CODINGS["png"].decode(CODINGS["png"].encode(values))
    assert read.dtype == values.dtype
    np.testing.assert_array_equal(read, values)


def test_jpeg_keeps_colours_in_their_order():
    smooth = np.broadcast_to(np.array([200, 90, 30], np.uint8), (32, 32, 3))
    read = CODINGS["jpeg"].decode(CODINGS["jpeg"].encode(np.ascontiguousarray(smooth)))
    assert np.abs(read.astype(int) - smooth).max() <= 3


def test_only_eight_bit_pictures_may_lose():
    assert coding_of("image_rgb", "jpeg") == "jpeg"
    assert coding_of("counts", "jpeg") == "blosc2"
    assert coding_of("counts", "png") == "png"
    assert coding_of("depth_m", "png") == "blosc2"


def test_bytes_that_are_no_picture_are_named():
    with pytest.raises(ValueError, match="picture: expected a PNG or JPEG file, got 4 bytes"):
        CODINGS["png"].decode(b"none")
