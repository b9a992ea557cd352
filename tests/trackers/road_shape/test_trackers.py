"""The papers' trackers and the baselines on hand-drawn pictures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.fakes import CAMERA, DrawnFrame, DrawnTown, along, bent_road, drive, look_down, straight_road
from trackers.baselines.single_target import best_match
from trackers.kernels.histogram import ColourTemplate
from trackers.registry import entry
from trackers.types import CameraModel, Estimate, Observation

FILTERS = ("colour_pf", "road_shape_pf", "background_pf")
REPRODUCIBLE = (*FILTERS, "hold", "constant_velocity")
HEIGHT_M = 60.0


@pytest.fixture(scope="module")
def bend() -> list[DrawnFrame]:
    """Return frames of a car on a bent road, always in view of a drifting and turning camera."""
    road = bent_road(40.0)
    town = DrawnTown(road, 220.0, np.random.default_rng(0))
    poses = [look_down(-25 + 0.55 * k, 2 + 0.1 * k, HEIGHT_M, 0.3 + 0.004 * k) for k in range(40)]
    return list(drive(town, road, 35.0, 0.65, poses))


def follow(name: str, frames: list[DrawnFrame], seed: int = 0) -> list[Estimate]:
    tracker = entry(name).create(np.random.default_rng(seed))
    tracker.initialise(frames[0].observation, frames[0].box_xyxy)
    return [tracker.update(frame.observation) for frame in frames[1:]]


def errors_px(estimates: list[Estimate], frames: list[DrawnFrame]) -> NDArray[np.float64]:
    pairs = zip(estimates, frames[1:], strict=True)
    return np.array([np.hypot(*(estimate.position_px - frame.position_px)) for estimate, frame in pairs])


@pytest.mark.heavy
@pytest.mark.parametrize("name", [*REPRODUCIBLE, "opencv_mil"])
def test_follows_a_car_in_view(name: str, bend: list[DrawnFrame]) -> None:
    half_car_px = 0.5 * 4.5 * CAMERA.focal_px / HEIGHT_M
    frames = bend[:15] if name == "opencv_mil" else bend
    assert np.median(errors_px(follow(name, frames), frames)) < half_car_px


@pytest.mark.heavy
@pytest.mark.parametrize("name", FILTERS)
def test_knows_where_the_car_is_heading(name: str, bend: list[DrawnFrame]) -> None:
    estimates = follow(name, bend)
    turned = [e.heading_rad - f.heading_rad for e, f in zip(estimates[15:], bend[16:], strict=True)]
    assert np.abs(np.angle(np.exp(1j * np.array(turned)))).max() < 0.5


@pytest.mark.parametrize("name", REPRODUCIBLE)
def test_the_same_seed_gives_the_same_answers(name: str, bend: list[DrawnFrame]) -> None:
    for first, second in zip(follow(name, bend[:8], 4), follow(name, bend[:8], 4), strict=True):
        np.testing.assert_array_equal(first.position_px, second.position_px)
        if first.particles_px is not None:
            np.testing.assert_array_equal(first.particles_px, second.particles_px)


def leaving() -> list[DrawnFrame]:
    """Return frames of a camera at rest while the car leaves over the right border."""
    road = straight_road()
    town = DrawnTown(road, 220.0, np.random.default_rng(1))
    return list(drive(town, road, 130.0, 1.2, [look_down(0, 0, HEIGHT_M, np.pi / 2)] * 35))


@pytest.mark.heavy
@pytest.mark.parametrize("name", [*REPRODUCIBLE, "opencv_mil"])
def test_estimates_are_finite_with_any_part_of_the_car_outside(name: str) -> None:
    frames = leaving()
    if name == "opencv_mil":
        frames = frames[::4]
    assert (frames[-1].box_xyxy[:2] > [CAMERA.width_px, 0]).all()
    for estimate in follow(name, frames):
        assert np.isfinite(estimate.position_px).all()
        assert estimate.box_xyxy is not None
        assert np.isfinite(estimate.box_xyxy).all()
        assert estimate.in_view_probability is None or 0 <= estimate.in_view_probability <= 1
        if estimate.weights is not None:
            assert estimate.weights.sum() == pytest.approx(1.0)
            assert np.isfinite(estimate.particles_px).all()


@pytest.mark.parametrize("name", REPRODUCIBLE)
def test_may_start_on_a_box_that_the_border_cuts(name: str, bend: list[DrawnFrame]) -> None:
    tracker = entry(name).create(np.random.default_rng(0))
    tracker.initialise(bend[0].observation, np.array([-12.0, 200.0, 20.0, 222.0]))
    assert np.isfinite(tracker.update(bend[1].observation).position_px).all()


@pytest.mark.parametrize("name", REPRODUCIBLE)
@pytest.mark.parametrize("box", [[700.0, 10, 740, 30], [50.0, 10, 40, 30], [np.nan, 0, 1, 1]])
def test_refuses_a_box_that_holds_nothing(name: str, box: list[float], bend: list[DrawnFrame]) -> None:
    tracker = entry(name).create(np.random.default_rng(0))
    with pytest.raises(ValueError, match="box_xyxy: expected"):
        tracker.initialise(bend[0].observation, np.array(box))


@pytest.mark.parametrize("name", FILTERS)
def test_one_particle_runs(name: str, bend: list[DrawnFrame]) -> None:
    tracker = entry(name).create(np.random.default_rng(0), particles=1)
    tracker.initialise(bend[0].observation, bend[0].box_xyxy)
    assert np.isfinite(tracker.update(bend[1].observation).position_px).all()


@pytest.mark.heavy
@pytest.mark.parametrize("name", FILTERS)
def test_runs_where_there_is_no_road(name: str) -> None:
    road = straight_road()
    town = DrawnTown(road, 160.0, np.random.default_rng(2), bare=True)
    frames = list(drive(town, road, 110.0, 0.6, [look_down(0, 0, HEIGHT_M, 0.0)] * 20, measured=False))
    assert np.median(errors_px(follow(name, frames), frames)) < 24


def frame_out_at_a_bend() -> list[DrawnFrame]:
    """Return frames of a camera that swings off the car in a bend and stays off it; motion is measured."""
    road = bent_road(30.0)
    town = DrawnTown(road, 260.0, np.random.default_rng(3))
    poses = []
    for k in range(49):
        car, _ = along(road, 45.0 + 0.6 * k)
        away = 38.0 * float(np.clip((k - 20) / 5, 0, 1))
        # The view swings ahead over the bend, so that its road is seen but the car is not.
        poses.append(look_down(car[0] + 0.3 * away, car[1] + away, HEIGHT_M, 0.0))
    return list(drive(town, road, 45.0, 0.6, poses))


def in_metres(points_px: NDArray[np.float64], frame: DrawnFrame, car_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places (N, 2) on the ground of pixels; world x is up in the picture, y left, the car is at ``car_m``."""
    return car_m - (points_px - frame.position_px)[:, ::-1] * HEIGHT_M / CAMERA.focal_px


@pytest.mark.heavy
def test_the_road_turns_a_filter_round_a_bend_that_the_plain_one_misses() -> None:
    """Its particles turn with the road and lie along the car's lane, more of them near the car.

    Its estimate is no nearer, for it runs ahead on the road: 4.8 to 7.4 m off over six seeds, the plain 4.1 to 4.7 m.
    """
    frames = frame_out_at_a_bend()
    road_m = bent_road(30.0)
    arcs = [along(road_m, arc_m) for arc_m in np.arange(30.0, 110.0, 0.5)]
    lane_m = np.array([place + 2.0 * np.array([np.sin(yaw), -np.cos(yaw)]) for place, yaw in arcs])
    at_end, yaw_at_end = along(road_m, 45.0 + 0.6 * 48)
    car_m = at_end + 2.0 * np.array([np.sin(yaw_at_end), -np.cos(yaw_at_end)])
    for frame in frames[28:]:
        x, y = frame.position_px
        assert not (0 <= x < CAMERA.width_px and 0 <= y < CAMERA.height_px)
    first_rad, last_rad = (along(bent_road(30.0), 45.0 + 0.6 * k)[1] for k in (20, 48))
    for seed in range(3):
        turned_rad, aside_m, near, error_m = {}, {}, {}, {}
        for name in ("colour_pf", "road_shape_pf"):
            said = follow(name, frames, seed)[-1]
            assert said.heading_rad is not None
            assert said.particles_px is not None
            # Headings in the picture are clockwise.
            turned_rad[name] = abs(wrapped(said.heading_rad + np.pi / 2 + last_rad))
            places_m = in_metres(said.particles_px, frames[-1], car_m)
            aside_m[name] = np.linalg.norm(places_m[:, None] - lane_m, axis=2).min(axis=1).mean()
            near[name] = (np.linalg.norm(places_m - car_m, axis=1) < 5.0).mean()
            error_m[name] = np.linalg.norm(in_metres(said.position_px[None], frames[-1], car_m) - car_m)
        # The plain filter still has the heading of the exit.
        assert turned_rad["colour_pf"] > 0.7 * abs(last_rad - first_rad)
        assert turned_rad["road_shape_pf"] < 0.6 * abs(last_rad - first_rad)
        assert aside_m["road_shape_pf"] < 2.0 < 4.0 < aside_m["colour_pf"]
        assert near["road_shape_pf"] > 1.3 * near["colour_pf"]
        assert max(error_m.values()) < 9.0


def wrapped(angle_rad: float) -> float:
    """Return an angle in [-pi, pi)."""
    return (angle_rad + np.pi) % (2 * np.pi) - np.pi


def test_the_background_filter_never_looks_at_the_measured_pose(bend: list[DrawnFrame]) -> None:
    blind = [replace(frame, observation=replace(frame.observation, ego=None)) for frame in bend[:10]]
    for first, second in zip(follow("background_pf", bend[:10]), follow("background_pf", blind), strict=True):
        np.testing.assert_array_equal(first.position_px, second.position_px)


def test_an_unknown_class_model_is_named() -> None:
    with pytest.raises(ValueError, match=r"class_model: expected .* got 'no_such_model'"):
        entry("background_pf").create(np.random.default_rng(0), class_model="no_such_model")


def test_what_lies_outside_the_picture_is_like_nothing() -> None:
    """Neither the border's pixels nor the whole picture's colours are used for it."""
    picture = np.full((40, 60, 3), (200, 40, 40), np.uint8)
    template = ColourTemplate.from_box(picture, np.array([10.0, 10.0, 20.0, 18.0]))
    _, similarity = best_match(template, picture, np.array([-3.0, 20.0]), reach_px=2.5)
    assert similarity == 0.0
    place_px, similarity = best_match(template, picture, np.array([-3.0, 20.0]), reach_px=8.0)
    assert similarity == pytest.approx(1.0)
    assert (place_px >= 0).all()


@pytest.mark.parametrize("name", ["hold", "constant_velocity"])
def test_where_all_places_are_alike_a_match_stays_in_place(name: str) -> None:
    """A grey picture has one hue and no saturation, so every place is as similar as any other."""
    grey = np.repeat(np.random.default_rng(0).integers(0, 256, (120, 160, 1)), 3, axis=-1).astype(np.uint8)
    observation = Observation(grey, 0.0, CameraModel(160, 120, 200.0))
    tracker = entry(name).create(np.random.default_rng(0))
    tracker.initialise(observation, np.array([70.0, 50.0, 94.0, 64.0]))
    for _ in range(20):
        assert np.abs(tracker.update(observation).position_px - (82.0, 57.0)).max() <= 1.0
