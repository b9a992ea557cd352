from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.judges.frame_out.metrics.localisation import on_object, on_other
from tests.benchmarks.hand_made import CAR_M, estimate_at, pixels_of, truth_of


def test_half_a_car_along_the_ground_is_still_on_it_and_more_is_not() -> None:
    places = np.array([[5.0, 3.0], [5.0, 3.0]])
    truth = truth_of(["in", "in"], places[:, None])
    off = places + np.array([[0.49 * CAR_M[0], 0.0], [0.51 * CAR_M[0], 0.0]])
    # Boxes far too small to overlap by half: the distance alone decides.
    assert on_object(truth, estimate_at(pixels_of(off), half_px=(0.1, 0.1))).tolist() == [[True], [False]]


def test_overlap_alone_suffices() -> None:
    places = np.array([[5.0, 3.0]])
    truth = truth_of(["in"], places[:, None])
    estimate = estimate_at(truth.position_px[:, 0])
    # The stated position is elsewhere, the box is right.
    elsewhere = estimate_at(truth.position_px[:, 0] + 60.0)
    mixed = replace(elsewhere, box_xyxy=estimate.box_xyxy)
    assert on_object(truth, mixed).all()
    assert not on_object(truth, elsewhere).any()


def test_it_holds_outside_the_picture_too() -> None:
    places = np.array([[500.0, 3.0]])
    truth = truth_of(["out"], places[:, None])
    assert on_object(truth, estimate_at(pixels_of(places + 0.5))).all()


def test_the_wrong_car_is_the_nearest_other_one_and_never_the_target() -> None:
    places = np.tile(np.array([[0.0, 0.0], [0.0, 8.0], [0.0, 9.5]]), (4, 1, 1))
    truth = truth_of(["in"] * 4, places)
    asked = np.array([[0.0, 0.5], [0.0, 8.2], [0.0, 9.4], [20.0, 20.0]])
    assert on_other(truth, estimate_at(pixels_of(asked))).tolist() == [-1, 1, 2, -1]


def test_a_tracker_that_says_nothing_is_on_nothing() -> None:
    truth = truth_of(["in"], np.zeros((1, 2, 2)))
    silent = estimate_at(np.full((1, 2), np.nan))
    assert not on_object(truth, silent).any()
    assert on_other(truth, silent).tolist() == [-1]
