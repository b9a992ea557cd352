"""Codings against the values that went in; channels as pictures: what differs looks different."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from benchmarks.data.sets.channels import CODINGS, EMPTY, channel_picture, coding_of
from scenarios.truth import Meaning

SIDES = st.tuples(st.integers(1, 20), st.integers(1, 20))
PICTURES = st.one_of(
    SIDES.flatmap(lambda side: arrays.arrays(np.uint8, (*side, 3))),
    SIDES.flatmap(lambda side: arrays.arrays(np.uint16, side)),
)
MAPS = st.one_of(
    SIDES.flatmap(lambda side: arrays.arrays(np.int32, side)),
    SIDES.flatmap(lambda side: arrays.arrays(np.float32, (*side, 2))),
)

NO_IDS = np.empty(0, dtype=np.int64)
METRES, IDS, MOTION = Meaning("m", ("H", "W")), Meaning("id", ("H", "W")), Meaning("px", ("H", "W", 2))


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


def test_a_picture_is_itself() -> None:
    image = np.random.default_rng(0).integers(0, 255, (4, 5, 3), dtype=np.uint8)
    np.testing.assert_array_equal(channel_picture("image_rgb", image, None, NO_IDS)[0], image)


def test_a_scale_grows_brighter_and_leaves_out_what_is_not_finite() -> None:
    depth = np.linspace(2.0, 4.0, 12, dtype=np.float32).reshape(3, 4)
    depth[0, 0] = np.inf
    image, words = channel_picture("depth_m", depth, METRES, NO_IDS)
    assert tuple(image[0, 0]) == EMPTY
    brightness = image.sum(axis=2).ravel()[1:].astype(int)
    assert (np.diff(brightness) >= 0).all()
    assert brightness[-1] > brightness[0]
    assert words == "2.2 to 3.98 m"


def test_a_wide_scale_is_logarithmic() -> None:
    depth = np.geomspace(1.0, 1000.0, 101, dtype=np.float32)[None]
    image, words = channel_picture("depth_m", depth, METRES, NO_IDS)
    assert words.endswith("log")
    # In equal steps 32 m would be as dark as 1 m.
    dark, middle, bright = image[0, [0, 50, 100]].astype(int)
    assert min(np.abs(middle - dark).sum(), np.abs(middle - bright).sum()) > 100


@pytest.mark.parametrize("value", [np.nan, np.inf, 3.0, 0.0])
def test_a_map_of_one_value_has_a_picture(value: float) -> None:
    image, _ = channel_picture("depth_m", np.full((3, 4), value, np.float32), METRES, NO_IDS)
    assert image.shape == (3, 4, 3)
    assert image.dtype == np.uint8
    assert len(np.unique(image.reshape(-1, 3), axis=0)) == 1


def test_objects_are_bright_and_apart_from_each_other_all_else_is_pale() -> None:
    ids = np.array([[-1, 5, 40_000, 7], [300, 5, 14, 21]], dtype=np.int32)
    image, _ = channel_picture("instance_map", ids, IDS, np.array([7, 14, 21, 28]))
    spread = np.ptp(image.astype(int), axis=2)
    of_object = np.isin(ids, (7, 14, 21))
    assert spread[of_object].min() > 120
    assert spread[~of_object].max() < 30
    bright = image[of_object].astype(int)
    assert min(np.abs(a - b).sum() for k, a in enumerate(bright) for b in bright[:k]) > 100
    np.testing.assert_array_equal(image[0, 1], image[1, 1])


def test_classes_have_colours_apart_the_same_in_every_picture() -> None:
    classes = Meaning("class", ("H", "W"))
    image, _ = channel_picture("semantic_map", np.arange(8, dtype=np.uint8)[None], classes, NO_IDS)
    colours = image[0].astype(int)
    assert min(np.abs(a - b).sum() for k, a in enumerate(colours) for b in colours[:k]) > 60
    alone, _ = channel_picture("semantic_map", np.full((1, 1), 5, np.uint8), classes, NO_IDS)
    np.testing.assert_array_equal(alone[0, 0], image[0, 5])


def test_motion_is_white_at_rest_and_opposite_ways_look_different() -> None:
    flow = np.zeros((1, 4, 2), dtype=np.float32)
    flow[0, 1], flow[0, 2], flow[0, 3] = (3.0, 0.0), (-3.0, 0.0), np.nan
    image, words = channel_picture("flow_px", flow, MOTION, NO_IDS)
    assert np.ptp(image[0, 0]) == 0
    assert image[0, 0, 0] > 230
    assert np.abs(image[0, 1].astype(int) - image[0, 2]).sum() > 300
    assert tuple(image[0, 3]) == EMPTY
    assert "3 px" in words


def test_normals_are_directions_and_nothing_where_there_is_no_surface() -> None:
    normals = np.array([[[0, 0, 1], [1, 0, 0], [0, 0, 0]]], dtype=np.float32)
    image, _ = channel_picture("normal_world", normals, None, NO_IDS)
    assert image[0].tolist() == [[127, 127, 255], [255, 127, 127], list(EMPTY)]


def test_counts_are_greys_between_their_ends() -> None:
    counts = np.arange(3000, 3100, dtype=np.uint16).reshape(10, 10)
    image, words = channel_picture("counts", counts, None, NO_IDS)
    assert (np.ptp(image, axis=2) == 0).all()
    assert (image[0, 0, 0], image[-1, -1, 0]) == (0, 255)
    assert words == "3,001 to 3,098"
