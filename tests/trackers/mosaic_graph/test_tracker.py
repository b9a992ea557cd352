"""Our tracker on hand-drawn films: through a frame-out, with and without measured motion, and its ablations."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.trackers.drawn_town import DrawnFrame, film
from trackers import registry
from trackers.types import Estimate

_FRAMES, _OUT = 64, (24, 44)


@pytest.fixture(scope="module")
def frames() -> list[DrawnFrame]:
    return film(0, _FRAMES, out=_OUT, with_ego=True)


def track(frames: list[DrawnFrame], name: str = "mosaic_graph_pf", seed: int = 0, **changes: object) -> list[Estimate]:
    """Return a tracker's answers from frame 1 on."""
    tracker = registry.entry(name).create(np.random.default_rng(seed), particles=400, **changes)
    tracker.initialise(frames[0].observation, frames[0].box_xyxy)
    return [tracker.update(frame.observation) for frame in frames[1:]]


@pytest.fixture(scope="module")
def estimates(frames: list[DrawnFrame]) -> list[Estimate]:
    return track(frames)


def error_px(frame: DrawnFrame, estimate: Estimate) -> float:
    return float(np.linalg.norm(estimate.position_px - frame.car_px))


@pytest.mark.heavy
def test_the_film_holds_a_frame_out(frames: list[DrawnFrame]) -> None:
    inside = np.array([frame.inside for frame in frames])
    assert inside[:20].all()
    assert not inside[28:40].any()
    assert inside[-8:].all()


@pytest.mark.heavy
def test_in_view_the_centre_is_within_a_quarter_of_a_car(frames: list[DrawnFrame], estimates: list[Estimate]) -> None:
    car_px = np.linalg.norm(frames[0].box_xyxy[2:] - frames[0].box_xyxy[:2])
    watched = [error_px(f, e) for f, e in zip(frames[1:21], estimates[:20], strict=True)]
    assert max(watched) < 0.25 * car_px


@pytest.mark.heavy
def test_outside_it_follows_the_road_and_reports_out_of_view(
    frames: list[DrawnFrame], estimates: list[Estimate]
) -> None:
    car_px = np.linalg.norm(frames[0].box_xyxy[2:] - frames[0].box_xyxy[:2])
    for k in range(30, 40):
        assert error_px(frames[k], estimates[k - 1]) < 1.5 * car_px
        assert estimates[k - 1].in_view_probability < 0.5


def test_it_is_back_on_the_car_with_a_box_that_fits(frames: list[DrawnFrame], estimates: list[Estimate]) -> None:
    for k in range(_FRAMES - 6, _FRAMES):
        box, truth = estimates[k - 1].box_xyxy, frames[k].box_xyxy
        assert box is not None
        common = np.prod(np.maximum(np.minimum(box[2:], truth[2:]) - np.maximum(box[:2], truth[:2]), 0.0))
        union = np.prod(box[2:] - box[:2]) + np.prod(truth[2:] - truth[:2]) - common
        assert common / union > 0.5
        assert estimates[k - 1].in_view_probability > 0.5


def test_the_posterior_grows_outside_and_holds_the_car(frames: list[DrawnFrame], estimates: list[Estimate]) -> None:
    spread = [float(np.linalg.norm(np.std(e.particles_px, axis=0))) for e in estimates]
    assert 3 * spread[20] < spread[38] < 12 * spread[20]
    car_px = np.linalg.norm(frames[0].box_xyxy[2:] - frames[0].box_xyxy[:2])
    for k in (30, 35, 40):
        said = estimates[k - 1]
        middle_px = np.average(said.particles_px, axis=0, weights=said.weights)
        aside_px = frames[k].car_px - middle_px
        # Within the ellipse that holds 95 % of a normal distribution, which is no wider than the car needs.
        assert aside_px @ np.linalg.solve(np.cov(said.particles_px.T, aweights=said.weights), aside_px) < 5.99
        assert said.weights[np.linalg.norm(said.particles_px - frames[k].car_px, axis=1) < car_px].sum() > 0.9


def test_the_weights_are_a_distribution(estimates: list[Estimate]) -> None:
    for estimate in estimates:
        assert estimate.weights is not None
        assert np.all(estimate.weights >= 0)
        assert estimate.weights.sum() == pytest.approx(1.0)
        assert len(estimate.weights) == len(estimate.particles_px)


def test_the_same_generator_gives_the_same_answer(frames: list[DrawnFrame]) -> None:
    short = frames[:10]
    for one, other in zip(track(short), track(short), strict=True):
        np.testing.assert_array_equal(one.position_px, other.position_px)
        np.testing.assert_array_equal(one.particles_px, other.particles_px)


@pytest.mark.heavy
def test_from_pixels_alone_it_finds_the_car_again(frames: list[DrawnFrame]) -> None:
    """With 400 particles two of seventeen generators took other things for the car, the first of them is 0."""
    blind = [
        dataclasses.replace(frame, observation=dataclasses.replace(frame.observation, ego=None)) for frame in frames
    ]
    worst_px = [
        max(error_px(f, e) for f, e in zip(frames[-5:], track(blind, seed=seed)[-5:], strict=True))
        for seed in (1, 2, 3)
    ]
    assert max(worst_px) < 6, worst_px


def test_ignoring_the_measured_motion_is_the_same_as_not_having_it(frames: list[DrawnFrame]) -> None:
    short = frames[:8]
    blind = [
        dataclasses.replace(frame, observation=dataclasses.replace(frame.observation, ego=None)) for frame in short
    ]
    for one, other in zip(track(short, "mosaic_graph_pf_no_ego"), track(blind), strict=True):
        np.testing.assert_array_equal(one.position_px, other.position_px)


def out_of_view(estimates: list[Estimate]) -> list[Estimate]:
    """Return the answers while the car was well outside; see ``test_the_film_holds_a_frame_out``."""
    return estimates[27:39]


@pytest.mark.heavy
def test_a_view_without_the_car_lowers_its_particles_but_in_the_ablation() -> None:
    """The car is gone. When the view swings back over part of the particles, those weigh less than the others."""
    gone = film(0, 46, out=_OUT, with_ego=True, decoys=0, jump_m=70.0)
    full, ablated = (track(gone, name) for name in ("mosaic_graph_pf", "mosaic_graph_pf_no_negative"))
    # At first only the border, where a detection is improbable, has swept over them.
    for said, at_most in ((full[43], 0.9), (full[44], 0.6)):
        inside = ((said.particles_px > 0) & (said.particles_px < [640, 480])).all(axis=1)
        assert said.weights[inside].mean() < at_most * said.weights[~inside].mean()
    for said in (ablated[43], ablated[44]):
        assert np.ptp(said.weights) < 1e-12


@pytest.mark.heavy
def test_without_roads_particles_stray_further_from_the_street(
    frames: list[DrawnFrame], estimates: list[Estimate]
) -> None:
    def aside_px(said: list[Estimate]) -> float:
        """Mean distance of particles from the line through the car along its street."""
        distances = []
        for frame, estimate in zip(frames[28:40], out_of_view(said), strict=True):
            along = frame.along_px / np.linalg.norm(frame.along_px)
            offset = estimate.particles_px - frame.car_px
            distances.append(np.abs(offset @ np.array([-along[1], along[0]])).mean())
        return float(np.mean(distances))

    assert aside_px(track(frames, "mosaic_graph_pf_no_roads")) > 1.5 * aside_px(estimates)


@pytest.mark.heavy
def test_only_redetection_finds_a_car_far_from_all_particles() -> None:
    """The car went back out of view."""
    jumped = film(0, 64, out=_OUT, with_ego=True, decoys=0, jump_m=-18.0)
    full, ablated = (track(jumped, name) for name in ("mosaic_graph_pf", "mosaic_graph_pf_no_redetection"))
    car_px = np.linalg.norm(jumped[0].box_xyxy[2:] - jumped[0].box_xyxy[:2])
    assert jumped[-1].inside
    assert error_px(jumped[-1], full[-1]) < 0.5 * car_px
    assert error_px(jumped[-1], ablated[-1]) > 2.0 * car_px


def test_without_the_mosaic_a_lost_car_is_expected_further_off(
    frames: list[DrawnFrame], estimates: list[Estimate]
) -> None:
    """Registration drifts, see ``test_pictures_are_registered_to_a_pixel_and_drift_without_the_mosaic``."""
    ablated = track(frames[:41], "mosaic_graph_pf_no_mosaic")
    outside = range(28, 41)
    full_px, ablated_px = (
        float(np.mean([error_px(frames[k], said[k - 1]) for k in outside])) for said in (estimates, ablated)
    )
    assert full_px < 5.0
    assert ablated_px > 1.2 * full_px


def test_one_particle_runs_and_begins_on_the_car(frames: list[DrawnFrame]) -> None:
    tracker = registry.entry("mosaic_graph_pf").create(np.random.default_rng(0), particles=1)
    tracker.initialise(frames[0].observation, frames[0].box_xyxy)
    said = [tracker.update(frame.observation) for frame in frames[1:10]]
    car_px = np.linalg.norm(frames[0].box_xyxy[2:] - frames[0].box_xyxy[:2])
    assert error_px(frames[1], said[0]) < 0.5 * car_px
    assert all(np.isfinite(estimate.position_px).all() for estimate in said)


def test_exactly_one_tracker_of_each_suite_is_ours() -> None:
    # Other tests register trackers of their own in the same process.
    own = {n: e for n, e in registry.entries().items() if e.tracker.__module__.startswith("trackers.")}
    ours = {suite: name for name, entry in own.items() if entry.role == "ours" for suite in entry.suites or ("",)}
    expected = {"": "mosaic_graph_pf", "stereo": "stereo_people", "fish": "shoal_chain", "harbour": "harbour_watch"}
    assert ours == expected, "named by none: the default suite's"
    assert [entry.role for entry in own.values()].count("ours") == len(ours)
