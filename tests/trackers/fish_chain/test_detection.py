"""Detection and posture on drawn tanks, against what was drawn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from tests.trackers.fish_chain.drawn_tank import Tank
from trackers.fish_chain.detection import Detection, Detector, DetectorParameters
from trackers.types import CameraModel, Observation


def detector(tank: Tank, background: int) -> Detector:
    new = Detector(DetectorParameters())
    new.start(tank.background(background))
    return new


@pytest.mark.heavy
@pytest.mark.parametrize(("paler", "background"), [(False, 20), (False, 0), (True, 0)])
def test_single_fish_are_found_with_their_posture(paler: bool, background: int) -> None:
    tank = Tank(count=4, seed=3, paler=paler)
    new = detector(tank, background)
    away_px, turned_rad, lines_px = [], [], []
    for frame in range(90):
        found = [each for each in new.detect(tank.draw()) if not each.merged]
        if frame < 30 or not found:
            continue
        places = np.array([each.position_px for each in found])
        distance = np.linalg.norm(places[:, None] - tank.positions_px[None], axis=2)
        for row, fish in zip(*linear_sum_assignment(distance), strict=True):
            line = tank.lines_px[fish]
            ahead = line[0] - line[len(line) // 2]
            away_px.append(distance[row, fish])
            turned_rad.append(found[row].heading_rad - np.arctan2(ahead[1], ahead[0]))
            lines_px.append(np.linalg.norm(found[row].centre_line_px - line, axis=1).mean())
    assert len(away_px) > 0.8 * 60 * tank.count
    assert np.median(away_px) < 0.6
    assert np.quantile(away_px, 0.9) < 1.7
    cosines = np.cos(turned_rad)
    assert np.median(cosines) > 0.99
    assert np.mean(cosines < 0) < 0.05
    assert np.median(lines_px) < 1.0


def test_lamps_that_are_brighter_than_fish_are_dark_are_no_fish() -> None:
    """They are fewer pixels, with more contrast in all."""
    tank, rng = Tank(count=3, seed=5), np.random.default_rng(0)
    tank._darkness[:] = 30.0
    new = detector(tank, 20)
    for frame in range(20):
        observation = tank.draw()
        shown = observation.image_rgb.copy()
        for x, y in rng.integers(5, [tank.size[0] - 9, tank.size[1] - 9], (14, 2)):
            shown[y : y + 5, x : x + 5] = 249
        found = new.detect(Observation(shown, observation.time_s, observation.camera))
        places = np.array([each.position_px for each in found]).reshape(-1, 2)
        for place in tank.positions_px:
            assert np.linalg.norm(places - place, axis=1).min(initial=np.inf) < 12.0, frame


def test_a_tail_that_comes_and_goes_does_not_move_the_middle() -> None:
    tank = Tank(count=3, seed=3)
    new = detector(tank, 20)
    for _ in range(60):
        new.detect(tank.draw())
    observation = tank.draw()
    whole = max(new.detect(observation), key=lambda each: each.length_px)
    tail, cut = whole.centre_line_px[-1], observation.image_rgb.copy()
    rows, columns = np.indices(cut.shape[:2])
    cut[np.hypot(columns + 0.5 - tail[0], rows + 0.5 - tail[1]) < 4.0] = np.median(cut, axis=(0, 1)).astype(np.uint8)
    found = new.detect(Observation(cut, observation.time_s, observation.camera))
    near = min(found, key=lambda each: float(np.linalg.norm(each.position_px - whole.position_px)))
    lost_px = whole.length_px - near.length_px
    assert lost_px > 2.0
    moved_px, of_line_px = (
        np.linalg.norm(at(near) - at(whole))
        for at in (lambda each: each.position_px, lambda each: each.centre_line_px[4])
    )
    assert of_line_px > 0.4 * lost_px
    assert moved_px < 0.85 * of_line_px


def test_fish_that_touch_are_one_merged_blob() -> None:
    tank = Tank(count=3, seed=1)
    new = detector(tank, 20)
    for _ in range(40):
        new.detect(tank.draw())
    tank.positions_px[1] = tank.positions_px[0] + (2.0, 3.0)
    tank.headings_rad[1] = tank.headings_rad[0] + 1.3
    found = new.detect(tank.draw())
    near = min(found, key=lambda each: float(np.linalg.norm(each.position_px - tank.positions_px[0])))
    assert near.merged
    assert sum(each.merged for each in found) == 1


def test_shadows_are_no_fish() -> None:
    tank = Tank(count=4, seed=5)
    new = detector(tank, 20)
    away_px = []
    for frame in range(80):
        observation = tank.draw()
        shadowed = observation.image_rgb.copy()
        dark = shadowed[..., 0] < 140
        below = np.roll(dark, (26, 9), axis=(0, 1)) & ~dark
        shadowed[below] = (0.72 * shadowed[below]).astype(np.uint8)
        found = new.detect(Observation(shadowed, observation.time_s, observation.camera))
        if frame >= 40:
            assert len(found) <= tank.count
            places = np.array([each.position_px for each in found])
            away_px += np.linalg.norm(tank.positions_px[:, None] - places[None], axis=2).min(axis=0).tolist()
    assert np.median(away_px) < 1.0
    assert np.quantile(away_px, 0.9) < 4.0
    assert new.norms.shadow > 0


def test_a_tank_without_shadows_has_none() -> None:
    tank = Tank(count=5, seed=2)
    new = detector(tank, 20)
    for _ in range(60):
        new.detect(tank.draw())
    assert new.norms.shadow == 0


def test_the_same_pictures_get_the_same_detections() -> None:
    runs: list[list[Detection]] = []
    for _ in range(2):
        tank = Tank(count=4, seed=8)
        new = detector(tank, 3)
        runs.append([each for _ in range(20) for each in new.detect(tank.draw())])
    assert len(runs[0]) == len(runs[1]) > 40
    for first, second in zip(*runs, strict=True):
        np.testing.assert_array_equal(first.centre_line_px, second.centre_line_px)


def test_the_light_as_a_whole_may_change() -> None:
    tank = Tank(count=4, seed=4)
    new = detector(tank, 20)
    for _ in range(40):
        new.detect(tank.draw())
    for _ in range(5):
        observation = tank.draw()
        dimmed = (0.8 * observation.image_rgb).astype(np.uint8)
        found = new.detect(Observation(dimmed, observation.time_s, observation.camera))
        assert 1 <= len(found) <= tank.count


@pytest.mark.parametrize("size", [(1, 1), (2, 3), (16, 16), (200, 4), (64, 48)])
@pytest.mark.parametrize("level", [0, 255, None])
def test_odd_pictures_are_no_error(size: tuple[int, int], level: int | None) -> None:
    rng = np.random.default_rng(0)
    new = Detector(DetectorParameters())
    new.start(())
    for frame in range(30):
        picture = rng.integers(0, 256, (size[1], size[0], 3), dtype=np.uint8) if level is None else None
        flat = np.full((size[1], size[0], 3), level or 0, np.uint8)
        for each in new.detect(
            Observation(flat if picture is None else picture, frame / 30, CameraModel(*size, 100.0))
        ):
            assert np.isfinite(each.centre_line_px).all()
