"""Our tracker where no pose is measured: on every picture it answers, and a target that was away is found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.trackers.mosaic_graph.drawn_flight import HEIGHT_PX, SIDE_PX, WIDTH_PX, FlownFrame, flight
from trackers import registry
from trackers.types import CameraModel, Estimate, Observation

_OUT = (20, 40)


def track(frames: list[FlownFrame], name: str = "mosaic_graph_pf", particles: int = 400) -> list[Estimate]:
    """Return a tracker's answers from frame 1 on."""
    tracker = registry.entry(name).create(np.random.default_rng(0), particles=particles)
    tracker.initialise(frames[0].observation, frames[0].box_xyxy)
    return [tracker.update(frame.observation) for frame in frames[1:]]


def error_px(frame: FlownFrame, estimate: Estimate) -> float:
    return float(np.linalg.norm(estimate.position_px - frame.centre_px))


@pytest.fixture(scope="module")
def away() -> list[FlownFrame]:
    return flight(62, out=_OUT)


@pytest.fixture(scope="module")
def said(away: list[FlownFrame]) -> list[Estimate]:
    return track(away)


def test_the_film_holds_a_frame_out(away: list[FlownFrame]) -> None:
    inside = np.array([frame.inside for frame in away])
    assert inside[:14].all()
    assert not inside[20:40].any()
    assert inside[-14:].all()


def test_it_is_on_the_target_to_a_pixel_before_it_leaves_and_after(
    away: list[FlownFrame], said: list[Estimate]
) -> None:
    for frame, estimate in (*zip(away[1:14], said, strict=False), *zip(away[-14:], said[-14:], strict=True)):
        assert error_px(frame, estimate) < 1.0
        assert estimate.in_view_probability > 0.9


def test_outside_it_is_expected_where_the_background_carries_it(away: list[FlownFrame], said: list[Estimate]) -> None:
    """The camera swings by six times the target's size, and the target drives on by another one."""
    for frame, estimate in zip(away[24:38], said[23:37], strict=True):
        assert not (0 < estimate.position_px[1] < HEIGHT_PX)
        assert error_px(frame, estimate) < SIDE_PX
        assert estimate.in_view_probability < 0.1


def test_the_posterior_outside_holds_the_target_and_grows(away: list[FlownFrame], said: list[Estimate]) -> None:
    spreads = []
    for frame, estimate in zip(away[24:38], said[23:37], strict=True):
        assert estimate.particles_px is not None
        assert estimate.weights is not None
        near = np.linalg.norm(estimate.particles_px - frame.centre_px, axis=1) < 3 * SIDE_PX
        assert estimate.weights[near].sum() > 0.5
        spreads.append(estimate.particles_px.std(axis=0).max())
    assert spreads[-1] > 1.3 * spreads[0]


@pytest.mark.parametrize("shift_px", [(9, 0), (-7, 11)])
def test_a_film_that_lies_elsewhere_moves_all_answers(shift_px: tuple[int, int]) -> None:
    here, there = (track(flight(16, shift_px=shift)) for shift in ((0, 0), shift_px))
    for one, other in zip(here, there, strict=True):
        np.testing.assert_allclose(other.position_px, one.position_px + shift_px, atol=0.6)
        np.testing.assert_allclose(other.box_xyxy, one.box_xyxy + np.tile(shift_px, 2), atol=1.2)


def test_the_box_grows_with_the_target() -> None:
    frames = flight(40, growth=1.7)
    estimate = track(frames)[-1]
    assert estimate.box_xyxy[2] - estimate.box_xyxy[0] == pytest.approx(1.7 * SIDE_PX, rel=0.08)


def test_only_redetection_finds_a_target_that_moved_on_unseen() -> None:
    frames = flight(46, out=(20, 22), jump_px=80.0)
    found, ablated = (track(frames, name) for name in ("mosaic_graph_pf", "mosaic_graph_pf_no_redetection"))
    assert frames[-1].inside
    assert error_px(frames[-1], found[-1]) < 1.0
    assert error_px(frames[-1], ablated[-1]) > SIDE_PX


def test_a_target_that_is_hidden_is_expected_in_place_and_not_in_view() -> None:
    frames = flight(40)
    for k in range(20, 32):
        image = frames[k].observation.image_rgb.copy()
        left, top, right, bottom = np.round(frames[k].box_xyxy).astype(int)
        image[top - 4 : bottom + 4, left - 4 : right + 4] = 128
        frames[k] = replace(frames[k], observation=replace(frames[k].observation, image_rgb=image))
    said = track(frames)
    for k in range(22, 32):
        assert error_px(frames[k], said[k - 1]) < 0.7 * SIDE_PX
        assert said[k - 1].in_view_probability < 0.5
    assert error_px(frames[-1], said[-1]) < 1.0


@pytest.mark.parametrize("size", [(1, 1), (2, 3), (16, 12), (200, 4)])
def test_it_answers_in_pictures_of_any_size(size: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    camera = CameraModel(*size, 100.0)
    pictures = rng.integers(0, 256, (6, size[1], size[0], 3), np.uint8)
    tracker = registry.entry("mosaic_graph_pf").create(np.random.default_rng(0), particles=50)
    tracker.initialise(Observation(pictures[0], 0.0, camera), np.array([0.0, 0.0, *size]))
    for k, picture in enumerate(pictures[1:], start=1):
        assert np.isfinite(tracker.update(Observation(picture, k / 10, camera)).position_px).all()


@pytest.mark.parametrize("level", [0, 255])
def test_blank_pictures_silence_it_never(away: list[FlownFrame], level: int) -> None:
    blank = Observation(np.full((HEIGHT_PX, WIDTH_PX, 3), level, np.uint8), 0.0, away[0].observation.camera)
    tracker = registry.entry("mosaic_graph_pf").create(np.random.default_rng(0), particles=50)
    tracker.initialise(away[0].observation, away[0].box_xyxy)
    for k in range(1, 30):
        estimate = tracker.update(replace(blank, time_s=k / 20))
        assert np.isfinite(estimate.position_px).all()
        assert estimate.box_xyxy is not None
    assert estimate.in_view_probability < 0.5


def test_grey_pictures_are_followed() -> None:
    frames = [
        replace(each, observation=replace(each.observation, image_rgb=_grey(each.observation.image_rgb)))
        for each in flight(25)
    ]
    assert error_px(frames[-1], track(frames)[-1]) < 1.0


def _grey(image_rgb: np.ndarray) -> np.ndarray:
    return np.repeat(image_rgb.mean(axis=2, keepdims=True), 3, axis=2).astype(np.uint8)
