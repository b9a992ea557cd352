"""Episodes of the harbour: determinism, truth where the pixels are, contrasts, the days before, both renderers."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.ndimage import distance_transform_cdt
from scipy.spatial.transform import Rotation

from scenarios.harbour.presets import PRESETS
from scenarios.harbour.scenario import HARBOUR, HarbourEpisode
from scenarios.harbour.truth import HarbourTruth
from scenarios.scenario import Frame
from scenarios.stage import SceneCamera
from scenarios.truth import check_truth, meanings
from sim.optics import project
from sim.render.pipeline import Capture
from sim.thermal.radiance import apparent_temperature_k
from tests.golden_picture import require_kept

SMALL = dataclasses.replace(PRESETS["quick"], background=5)
SEED, FRAMES = 5, 26


def take(episode: HarbourEpisode, count: int) -> Iterator[Frame]:
    for _ in range(count):
        yield episode.step()


def bytes_of(frame: Frame) -> list[bytes]:
    held: list[Any] = [frame.observation.image_rgb, frame.observation.counts]
    held += [getattr(frame.truth, name) for name in meanings(HarbourTruth)]
    return [np.asarray(each).tobytes() for each in held]


@pytest.fixture(scope="module")
def captures() -> list[Capture[Any]]:
    return []


@pytest.fixture(scope="module")
def seen(captures: list[Capture[Any]]) -> Iterator[tuple[HarbourEpisode, list[Frame]]]:
    """Return the first frames of an episode; ``captures`` get what its camera took."""
    with pytest.MonkeyPatch.context() as patch:
        own = SceneCamera.take

        def recorded(self: SceneCamera, *given: Any, **named: Any) -> Capture[Any]:
            captures.append(own(self, *given, **named))
            return captures[-1]

        patch.setattr(SceneCamera, "take", recorded)
        episode = HARBOUR.episode(SMALL, SEED)
        frames = list(take(episode, FRAMES))
        assert len(episode.start.background) == SMALL.background
    yield episode, frames
    episode.close()


def truth_of(frame: Frame) -> HarbourTruth:
    assert isinstance(frame.truth, HarbourTruth)
    return frame.truth


def objects(frames: list[Frame]) -> Iterator[tuple[int, HarbourTruth, int]]:
    """Yield frame, truth and index of all that are there."""
    for number, frame in enumerate(frames):
        truth = truth_of(frame)
        for k in np.flatnonzero(truth.state != "absent").tolist():
            yield number, truth, k


@pytest.mark.heavy
def test_an_episode_is_the_same_bytes_again_whenever_the_days_before_are_looked_at(seen: Any) -> None:
    again = HARBOUR.episode(SMALL, SEED)
    before = again.start.background
    for first, second in zip(seen[1], take(again, 18), strict=False):
        assert bytes_of(first) == bytes_of(second)
    for ours, theirs in zip(seen[0].start.background, before, strict=True):
        assert ours.time_s == theirs.time_s
        assert ours.counts is not None
        assert theirs.counts is not None
        np.testing.assert_array_equal(ours.counts, theirs.counts)
        np.testing.assert_array_equal(ours.image_rgb, theirs.image_rgb)
    again.close()
    other = HARBOUR.episode(SMALL, SEED + 1)
    assert bytes_of(other.step())[1] != bytes_of(seen[1][0])[1]
    other.close()


def test_observations_are_those_of_a_thermal_camera(seen: Any) -> None:
    for frame in seen[1]:
        check_truth(frame.truth)
        observation = frame.observation
        assert observation.camera.band == "thermal"
        assert observation.settings is None
        assert observation.counts is not None
        assert observation.counts.dtype == np.uint16
        assert observation.counts.max() < 2**14
        grey = observation.image_rgb
        assert (grey == grey[..., :1]).all()
        # Once for the whole episode, by instruments that err a little.
        measured = observation.ego.T_world_camera
        np.testing.assert_array_equal(measured, seen[1][0].observation.ego.T_world_camera)
        off = measured[:3, 3] - frame.truth.T_world_camera[:3, 3]
        assert 0.001 < np.linalg.norm(off) < 0.25
        turned = Rotation.from_matrix(measured[:3, :3].T @ frame.truth.T_world_camera[:3, :3])
        assert 0.001 < np.degrees(turned.magnitude()) < 0.12


def test_a_person_a_car_and_a_boat_come(seen: Any) -> None:
    came = {truth.kinds[k] for _, truth, k in objects(seen[1]) if truth.state[k] == "in"}
    assert came == {"person", "car", "boat"}
    assert HARBOUR.target in seen[1][0].truth.names


def test_boxes_are_where_the_pixels_are_and_3d_boxes_contain_them(seen: Any) -> None:
    gaps = []
    for _, truth, k in objects(seen[1]):
        corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])
        points = (corners * truth.size_m[k]) @ truth.T_world_object[k, :3, :3].T + truth.T_world_object[k, :3, 3]
        corner_px = project(seen[1][0].camera, truth.T_world_camera, points)[0]
        solid = np.concatenate([corner_px.min(axis=0), corner_px.max(axis=0)])
        slack_px = 3.0 if truth.kinds[k] == "person" else 1.5
        # A stride is longer than a standing person.
        assert (truth.box_xyxy[k, :2] > solid[:2] - slack_px).all(), truth.names[k]
        assert (truth.box_xyxy[k, 2:] < solid[2:] + slack_px).all(), truth.names[k]
        if truth.state[k] != "in" or truth.visible_fraction[k] < 1.0:
            continue
        rows, columns = np.nonzero(truth.instance_map == truth.instance_id[k])
        box = np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1])
        gaps.append((box - truth.box_xyxy[k]) * (1, 1, -1, -1))
        # A boat that rolls shows some of its hull below the waterline.
        assert gaps[-1].min() > (-2.0 if truth.kinds[k] == "boat" else -0.6), truth.names[k]
    assert len(gaps) > 15
    # Pixels are sampled at their centres: on average they miss half a pixel on each side, thin masts more.
    assert np.abs(np.median(gaps, axis=0)).max() < 1.0


def test_who_is_absent_has_no_box_no_pixel_and_no_contrast(seen: Any) -> None:
    found = 0
    for frame in seen[1]:
        truth = truth_of(frame)
        away = truth.state == "absent"
        found += int(away.sum())
        assert np.isnan(truth.box_xyxy[away]).all()
        assert np.isnan(truth.position_px[away]).all()
        assert np.isnan(truth.temperature_contrast_k[away]).all()
        assert not truth.watched[away].any()
        assert not np.isin(truth.instance_map, truth.instance_id[away]).any()
        there = ~away & (truth.visible_fraction > 0)
        assert np.isfinite(truth.temperature_contrast_k[there]).all()
    assert found > 0


def test_contrast_is_that_of_the_pixels_to_the_ring_around_them(seen: Any, captures: list[Capture[Any]]) -> None:
    """Rings by distance from the pixels, in the whole picture."""
    checked = 0
    for number, truth, k in objects(seen[1]):
        own = truth.instance_map == truth.instance_id[k]
        if not own.any():
            continue
        kelvin = apparent_temperature_k(captures[number].picture.radiance)
        ring = (distance_transform_cdt(~own, "chessboard") <= 3) & ~np.isin(truth.instance_map, truth.instance_id)
        above = kelvin[own] - kelvin[ring].mean()
        assert truth.temperature_contrast_k[k] == pytest.approx(above.mean(), abs=1e-9)
        assert truth.contrast_to_noise[k] == pytest.approx(np.sqrt((above**2).sum()) / 0.06, rel=1e-9)
        checked += 1
    assert checked > 20


def test_the_sensor_sees_the_contrast_that_truth_tells(seen: Any) -> None:
    """Pixels of what differs clearly do so in the counts as in the radiance, by the sensor's counts for a kelvin."""
    ours, told = [], []
    for number, truth, k in objects(seen[1]):
        own = truth.instance_map == truth.instance_id[k]
        if own.sum() < 60:
            continue
        near = (distance_transform_cdt(~own, "chessboard") <= 3) & ~np.isin(truth.instance_map, truth.instance_id)
        counts = seen[1][number].observation.counts.astype(float)
        ours.append(counts[own].mean() - counts[near].mean())
        told.append(truth.temperature_contrast_k[k])
    assert len(ours) > 10
    per_kelvin = np.array(ours) / np.array(told)
    assert np.ptp(per_kelvin[np.abs(told) > 3.0]) < 0.25 * np.median(per_kelvin)


def test_the_gain_is_the_slope_of_grey_over_kelvin(seen: Any, captures: list[Capture[Any]]) -> None:
    for number, frame in enumerate(seen[1]):
        kelvin = apparent_temperature_k(captures[number].picture.radiance).ravel()
        low, high = np.quantile(kelvin, (0.25, 0.75))
        near = [np.abs(kelvin - each) < 0.05 for each in (low, high)]
        grey = frame.observation.image_rgb[..., 0].ravel().astype(float)
        slope = (grey[near[1]].mean() - grey[near[0]].mean()) / (high - low)
        assert truth_of(frame).agc_gain == pytest.approx(slope, rel=0.06)


def test_every_id_in_the_map_is_of_an_object_or_told_by_the_map(seen: Any) -> None:
    told = seen[0].map_of().clutter
    assert set(told.values()) == {"sea", "moored", "rope", "bird", "parked", "land", "building"}
    there: set[str] = set()
    for frame in seen[1]:
        ids = set(np.unique(frame.truth.instance_map).tolist()) - {-1} - set(frame.truth.instance_id.tolist())
        assert ids <= set(told)
        there |= {told[each] for each in ids}
    assert there == set(told.values())


def test_the_days_before_are_without_intruders_and_differ(seen: Any, captures: list[Capture[Any]]) -> None:
    background = seen[0].start.background
    times = [each.time_s for each in background]
    assert times == sorted(times)
    assert times[0] == -3 * 86400.0
    assert -86400.0 < times[-1] < 0.0
    taken = captures[FRAMES:]
    assert len(taken) == len(background)
    intruders = seen[1][0].truth.instance_id
    for capture, picture in zip(taken, background, strict=True):
        np.testing.assert_array_equal(capture.picture.counts, picture.counts)
        assert capture.instance_id.max() < intruders.min()
    kelvin = [apparent_temperature_k(each.picture.radiance) for each in taken]
    assert np.ptp([each.mean() for each in kelvin]) > 1.0
    # Moored boats do not lie where they lay.
    assert (taken[0].instance_id != taken[1].instance_id).mean() > 0.002


@pytest.mark.heavy
def test_no_noise_of_a_long_episode_comes_again_on_the_days_before(monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[int] = []
    own = SceneCamera.take

    def recorded(self: SceneCamera, shader: Any, T: Any, frame: int) -> Capture[Any]:
        taken.append(frame)
        return own(self, shader, T, frame)

    monkeypatch.setattr(SceneCamera, "take", recorded)
    for count in (100, 4200):
        episode = HARBOUR.episode(dataclasses.replace(SMALL, frame_count=count, background=2), SEED)
        assert len(episode.start.background) == len(taken) == 2
        # 36 hours at one picture each two seconds lie between the two.
        assert taken == [max(count, 4000), max(count, 4000) + 64800]
        episode.close()
        taken.clear()


@pytest.mark.heavy
def test_both_renderers_show_the_same(seen: Any) -> None:
    """Two of 110,592 pixels differ; one part of a person, or a rope, would be more than the ten that may."""
    episode = HARBOUR.episode(SMALL, SEED, renderer="pybullet")
    frame, ours = episode.step(), seen[1][0]
    other = frame.truth.instance_map != ours.truth.instance_map
    assert np.count_nonzero(other) <= 10
    # Where they differ both see an edge.
    ids = ours.truth.instance_map.astype(np.float32)
    edge = cv2.dilate(ids, np.ones((3, 3), np.uint8)) != cv2.erode(ids, np.ones((3, 3), np.uint8))
    assert not (other & ~edge).any()
    off = np.abs(frame.observation.counts.astype(float) - ours.observation.counts)
    # Counts; they spread by 600 over the picture.
    assert np.median(off[~edge]) < 5.0
    assert np.percentile(off[~edge], 95) < 40.0
    episode.close()


def test_it_looks_as_it_did(seen: Any, request: pytest.FixtureRequest) -> None:
    require_kept(seen[1][20].observation.image_rgb, "harbour", request)
