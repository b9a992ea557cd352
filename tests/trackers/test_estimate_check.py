from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from trackers.estimate_check import check_estimate, check_tracks
from trackers.regions import Mask, estimate_of
from trackers.types import CameraModel, Estimate, Track

HERE = np.array([3.0, 4.0])
BOX = np.array([1.0, 2.0, 5.0, 6.0])
MASK = np.zeros((8, 12), bool)
MASK[2:5, 3:9] = True
POINTS = np.zeros((3, 2))


class Unshowable:
    """Has no words."""

    def __repr__(self) -> str:
        raise RuntimeError("no words")


@pytest.mark.parametrize(
    "estimate",
    [
        Estimate(HERE),
        Estimate(np.array([-1e5, 4])),
        Estimate(np.full(2, np.nan)),
        Estimate(np.full(2, np.nan), box_xyxy=np.full(4, np.nan), heading_rad=float("nan")),
        Estimate(HERE, BOX, 0.3, 0.0, POINTS, np.array([0.2, 0.3, 0.5]), np.eye(2)),
        Estimate(HERE, particles_px=np.array([[np.nan, 0.0], [1.0, 2.0]])),
        Estimate(HERE, covariance_px=np.zeros((2, 2))),
        Estimate(HERE, in_view_probability=1),
        Estimate(HERE, depth_m=2.5),
        Estimate(np.full(2, np.nan), depth_m=float("nan")),
        Estimate(HERE, BOX, mask=MASK),
        Estimate(HERE, mask=np.zeros_like(MASK)),
    ],
)
def test_what_the_contract_allows_passes(estimate: Estimate) -> None:
    checked = check_estimate(estimate)
    for field in fields(Estimate):
        given, kept = getattr(estimate, field.name), getattr(checked, field.name)
        assert (given is None) == (kept is None)
        if given is not None:
            np.testing.assert_array_equal(kept, np.asarray(given))
            assert not np.shares_memory(kept, given)


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ([3, 4], HERE),
        (("3", "4"), HERE),
        (np.array([3, 4], np.uint8), HERE),
        (np.array([3, 4], np.float16), HERE),
        (np.array([3, 4], np.float32), HERE.astype(np.float32)),
    ],
)
def test_numbers_of_other_kinds_are_kept_as_a_judge_needs_them(given: Any, kept: Any) -> None:
    checked = check_estimate(
        Estimate(
            given, [*given, *given], covariance_px=[[4, 0], [0, 4]], particles_px=[given] * 3, weights=[0, 0.5, 0.5]
        )  # type: ignore[arg-type]
    )
    assert checked.position_px.dtype == kept.dtype
    np.testing.assert_array_equal(checked.position_px, kept)
    np.testing.assert_array_equal(checked.box_xyxy, np.tile(kept, 2))  # type: ignore[arg-type]
    np.testing.assert_array_equal(checked.covariance_px, 4 * np.eye(2))  # type: ignore[arg-type]
    np.testing.assert_array_equal(checked.particles_px, np.tile(kept, (3, 1)))  # type: ignore[arg-type]


def test_tensors_are_taken_with_a_gradient_too() -> None:
    torch = pytest.importorskip("torch")
    checked = check_estimate(Estimate(torch.tensor(HERE, requires_grad=True), in_view_probability=torch.tensor(0.5)))
    np.testing.assert_array_equal(checked.position_px, HERE)
    assert checked.in_view_probability == 0.5


def test_a_probability_may_be_off_by_rounding() -> None:
    assert check_estimate(Estimate(HERE, in_view_probability=1 + 1e-6)).in_view_probability == 1.0
    assert check_estimate(Estimate(HERE, in_view_probability=np.float32(-1e-7))).in_view_probability == 0.0  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("estimate", "message"),
    [
        (None, "update: expected an Estimate, .*, got None"),
        ((3.0, 4.0), "update: expected an Estimate, .*, got tuple"),
        (Estimate(np.zeros(3)), r"position_px: expected the shape \(2,\), got \(3,\)"),
        (Estimate(np.array([np.nan, 1.0])), r"position_px: expected finite numbers, got \[nan, 1.0\]"),
        (Estimate(np.array([np.inf, 1.0])), "position_px: expected finite numbers"),
        (Estimate("here"), r"position_px: expected numbers of shape \(2,\), got 'here'"),  # type: ignore[arg-type]
        (Estimate(HERE, np.zeros((2, 2))), r"box_xyxy: expected the shape \(4,\), got \(2, 2\)"),
        (Estimate(HERE, np.full(4, np.nan)), "box_xyxy: expected finite numbers"),
        (
            Estimate(HERE, np.array([5.0, 2.0, 1.0, 6.0])),
            "box_xyxy: .* x_min <= x_max .*; is it left, top, wid",
        ),
        (Estimate(HERE, depth_m=0.0), r"depth_m: expected a finite number > 0, got 0.0"),
        (Estimate(HERE, depth_m=float("inf")), r"depth_m: expected a finite number > 0, got inf"),
        (Estimate(HERE, depth_m=float("nan")), r"depth_m: expected a finite number > 0, got nan"),
        (Estimate(HERE, heading_rad=float("nan")), "heading_rad: expected finite numbers"),
        (Estimate(np.full(2, np.nan), heading_rad=np.full(1, np.nan)), "heading_rad: expected the shape"),
        (Estimate(np.full(2, np.nan), covariance_px=np.full(2, np.nan)), "covariance_px: expected the shape"),
        (Estimate(HERE, centre_line_px=np.zeros((3, 3))), "centre_line_px: expected the shape"),
        (Estimate(HERE, in_view_probability=1.2), "in_view_probability: expected a number from 0 to 1, got 1.2"),
        (Estimate(HERE, in_view_probability=float("nan")), "in_view_probability: expected a number from 0 to 1"),
        (Estimate(HERE, particles_px=np.zeros((0, 2))), "particles_px: expected at least one particle, got none"),
        (Estimate(HERE, particles_px=np.zeros((3, 3))), r"particles_px: expected the shape \(3, 2\), got \(3, 3\)"),
        (
            Estimate(HERE, particles_px=POINTS, weights=np.ones(2) / 2),
            r"weights: expected the shape \(3,\), got \(2,\)",
        ),
        (Estimate(HERE, particles_px=POINTS, weights=np.ones(3)), "weights: expected .* the sum 1, got .* the sum 3"),
        (Estimate(HERE, particles_px=POINTS, weights=np.array([1.5, -0.5, 0.0])), "weights: .* got the least -0.5"),
        (Estimate(HERE, particles_px=POINTS, weights=np.full(3, np.nan)), "weights: expected non-negative numbers"),
        (Estimate(HERE, particles_px=np.zeros((300_000, 2))), "particles_px: expected at most 10,000 .*, got 300,000"),
        (Estimate(HERE, particles_px=[[1.0, 2.0], [3.0]]), r"particles_px: expected numbers of shape \(N, 2\), got"),  # type: ignore[arg-type]
        (Estimate(HERE + 1j), r"position_px: expected numbers of shape \(2,\), got array"),
        (Estimate(Unshowable()), "position_px: expected numbers .*, got a Unshowable that cannot be shown"),  # type: ignore[arg-type]
        (Estimate(HERE, weights=np.ones(1)), "weights: expected None without particles_px"),
        (
            Estimate(HERE, covariance_px=np.array([[1.0, 2.0], [2.0, 1.0]])),
            "covariance_px: expected a symmetric matrix",
        ),
        (
            Estimate(HERE, covariance_px=np.array([[1.0, 0.5], [0.0, 1.0]])),
            "covariance_px: expected a symmetric matrix",
        ),
        (Estimate(HERE, covariance_px=np.full((2, 2), np.nan)), "covariance_px: expected finite numbers"),
    ],
)
def test_what_breaks_it_is_named(estimate: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check_estimate(estimate)


CAMERA = CameraModel(12, 8, 10.0)


@pytest.mark.parametrize("kind", [bool, np.uint8, np.int64])
def test_a_mask_gives_its_box_where_there_is_none(kind: Any) -> None:
    answer = Estimate(HERE, mask=(MASK.astype(kind) * 255 if kind is not bool else MASK))
    for checked in (check_estimate(answer, CAMERA), check_tracks([Track(0, answer)], CAMERA)[0].estimate):
        assert checked.mask is not None
        assert checked.mask.dtype == bool
        np.testing.assert_array_equal(checked.mask, MASK)
        np.testing.assert_array_equal(checked.box_xyxy, [3, 2, 9, 5])  # type: ignore[arg-type]
    whole = check_estimate(estimate_of(Mask(MASK), *MASK.shape), CAMERA)
    assert whole.position_px.tolist() == [6, 3.5]
    np.testing.assert_array_equal(whole.mask, MASK)  # type: ignore[arg-type]
    assert check_estimate(Estimate(HERE, BOX, mask=MASK), CAMERA).box_xyxy.tolist() == BOX.tolist()  # type: ignore[union-attr]


def test_without_a_position_or_a_pixel_there_is_no_box_of_a_mask() -> None:
    silent = check_estimate(Estimate(np.full(2, np.nan), mask=MASK), CAMERA)
    assert (silent.mask, silent.box_xyxy) == (None, None)
    outside = check_estimate(Estimate(np.array([-5.0, 3.0]), mask=np.zeros_like(MASK)), CAMERA)
    assert outside.mask is not None
    assert outside.box_xyxy is None


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        (MASK.T, r"mask: expected the picture's shape \(8, 12\), got \(12, 8\)"),
        (MASK.astype(float), r"mask: expected bool of shape \(H, W\), got float64 of shape \(8, 12\)"),
        (MASK[None], r"mask: expected bool of shape \(H, W\), got bool of shape \(1, 8, 12\)"),
        (np.arange(96).reshape(8, 12), "mask: expected 0 and one other number, got several"),
        ("here", r"mask: expected bool of shape \(H, W\), got 'here'"),
        ([[1, 0], [1]], r"mask: expected bool of shape \(H, W\), got"),
    ],
)
def test_what_is_wrong_with_a_mask_is_named(mask: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check_estimate(Estimate(HERE, mask=mask), CAMERA)
