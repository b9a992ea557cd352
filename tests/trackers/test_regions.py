from __future__ import annotations

import json
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from numpy.testing import assert_allclose, assert_array_equal

from tests.trackers.record_vot_toolkit import FILE, HEIGHT_PX, WIDTH_PX
from trackers.regions import Mask, Point, Polygon, Rectangle, Special, estimate_of, read_confidence, read_region

REGIONS = json.loads(FILE.read_text())["regions"]
masks = arrays(bool, array_shapes(min_dims=2, max_dims=2, min_side=0, max_side=9))
pixels = st.floats(-1e4, 1e4)


def of_kind(kind: str) -> list[Any]:
    return [each for each in REGIONS if each["kind"] == kind]


def toolkits_mask(recorded: Any) -> Any:
    return np.array([[int(bit) for bit in row] for row in recorded["rows"]], bool)


@pytest.mark.parametrize("recorded", REGIONS, ids=lambda recorded: recorded["text"][:30])
def test_kinds_and_numbers_are_those_of_the_vot_toolkit(recorded: Any) -> None:
    region = read_region(recorded["text"])
    assert type(region).__name__ == recorded["kind"]
    match region:
        case Special():
            assert region.code == recorded["code"]
        case Point():
            assert region.position_px.tolist() == recorded["numbers"]
        case Rectangle() | Polygon():
            x, y, width, height = recorded["numbers"]
            assert_allclose(region.box_xyxy, [x, y, x + width, y + height], atol=1e-5)
        case Mask():
            assert str(region) == recorded["written"]


@pytest.mark.parametrize("recorded", of_kind("Rectangle") + of_kind("Mask"), ids=lambda recorded: recorded["text"][:30])
def test_pixels_of_rectangles_and_masks_are_those_of_the_vot_toolkit(recorded: Any) -> None:
    assert_array_equal(read_region(recorded["text"]).mask(HEIGHT_PX, WIDTH_PX), toolkits_mask(recorded))


@pytest.mark.parametrize("recorded", of_kind("Polygon")[:3], ids=lambda recorded: recorded["text"][:30])
def test_pixels_of_convex_polygons_are_those_of_the_vot_toolkit_but_for_their_border(recorded: Any) -> None:
    ours, theirs = read_region(recorded["text"]).mask(HEIGHT_PX, WIDTH_PX), toolkits_mask(recorded)
    around = np.ones((3, 3), np.uint8)
    border = cv2.morphologyEx(theirs.astype(np.uint8), cv2.MORPH_GRADIENT, around).astype(bool)
    assert theirs.sum() > 70
    assert_array_equal(ours & ~border, theirs & ~border)


def test_a_polygon_of_a_rectangles_corners_has_its_border_too() -> None:
    polygon = read_region("2,3,12,3,12,9,2,9")
    assert_array_equal(polygon.mask(HEIGHT_PX, WIDTH_PX), toolkits_mask(of_kind("Polygon")[0]))
    assert polygon.box_xyxy.tolist() == [2, 3, 12, 9]
    assert polygon.mask(HEIGHT_PX, WIDTH_PX).sum() == 11 * 7


@given(masks, st.integers(-20, 20), st.integers(-20, 20))
def test_a_mask_that_was_written_is_read_with_the_same_pixels_in_every_picture(mask: Any, x: int, y: int) -> None:
    written = Mask(mask, x, y)
    read = read_region(str(written))
    assert isinstance(read, Mask)
    ours = written.mask(15, 12)
    assert_array_equal(read.mask(15, 12), ours)
    by_hand = np.zeros((60, 60), bool)
    by_hand[20 + y : 20 + y + mask.shape[0], 20 + x : 20 + x + mask.shape[1]] = mask
    assert_array_equal(ours, by_hand[20:35, 20:32])
    if mask.any():
        rows, columns = np.nonzero(mask)
        wanted = [columns.min() + x, rows.min() + y, columns.max() + x + 1, rows.max() + y + 1]
        assert read.box_xyxy is not None
        assert read.box_xyxy.tolist() == wanted
    else:
        assert read.box_xyxy is None


@given(arrays(float, (2, 2), elements=pixels), arrays(float, (5, 2), elements=pixels))
def test_rectangles_and_polygons_that_were_written_are_read_again(two: Any, corners: Any) -> None:
    box = np.concatenate((two.min(axis=0), two.max(axis=0)))
    assert_allclose(read_region(str(Rectangle(box))).box_xyxy, box, atol=1e-9)
    read = read_region(str(Polygon(corners)))
    assert isinstance(read, Polygon)
    assert_array_equal(read.corners_px, corners)


def test_an_estimate_of_a_region_is_silent_where_the_region_has_no_area() -> None:
    for text in ("0", "2", "5,5,0,0", "5,5,0,3", "m4,4,3,2,6", "m0,0,0,0,0", "4,4,9,4,6,4"):
        assert np.isnan(estimate_of(read_region(text), 20, 20).position_px).all(), text


def test_an_estimate_of_a_region_has_the_middle_of_its_box() -> None:
    rectangle = estimate_of(read_region("2,4,10,6"), 20, 20)
    assert rectangle.position_px.tolist() == [7, 7]
    assert rectangle.box_xyxy is not None
    assert rectangle.box_xyxy.tolist() == [2, 4, 12, 10]
    assert rectangle.mask is None
    mask = estimate_of(read_region("m18,4,4,3,0,12"), 20, 20)
    assert mask.position_px.tolist() == [20, 5.5]
    assert mask.mask is not None
    assert np.argwhere(mask.mask).tolist() == [[row, column] for row in (4, 5, 6) for column in (18, 19)]
    point = estimate_of(read_region("2.5,4"), 20, 20)
    assert (point.position_px.tolist(), point.box_xyxy) == ([2.5, 4], None)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [("0.5", 0.5), (" 1\r\n", 1.0), ("0", 0.0)] + [(text, None) for text in ("", "sure", "nan", "inf", "1.01", "-0.1")],
)
def test_a_confidence_is_a_probability_or_none(text: str, wanted: float | None) -> None:
    assert read_confidence(text) == wanted


WRONG = (
    "|m|m1,2|m1,2,3|m1,2,-3,4|m1,2,3,4,13|m1,2,3,4,-1,2|m1.5,2,3,4|m0,0,99999,99999|1,2,3|1,2,3,4,5|1,2,-3,4|a,b,c,d"
)
WRONG += "|1,2,inf,4|1.5|nan|1,2,3,4,5,6,7|1,,3,4|m0,0,1,1," + "9" * 5000


@pytest.mark.parametrize("text", WRONG.split("|"), ids=lambda text: text[:30])
def test_a_text_that_is_no_region_gets_one_message(text: str) -> None:
    with pytest.raises(ValueError, match=r"region: expected a code, or x,y, or .*; got '") as raised:
        read_region(text)
    assert len(str(raised.value)) < 260
