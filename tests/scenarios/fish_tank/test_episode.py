"""Episodes of the tank: determinism, truth after refraction, both renderers, the steered camera."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.fish_tank.presets import PRESETS, ZEBRAFISH
from scenarios.fish_tank.scenario import FISH_TANK, FishTankEpisode
from scenarios.fish_tank.tank import VOLUME_M
from scenarios.fish_tank.truth import FishTruth
from scenarios.scenario import Frame
from scenarios.truth import check_truth, meanings
from sim.render.refraction import project_through
from sim.water_surface import RippledSurface, Ripples, Waves
from trackers.types import CameraCommand

SMALL = dataclasses.replace(PRESETS["quick"], fish=12, frame_count=30)


def frames(episode: FishTankEpisode, count: int, command: CameraCommand | None = None) -> Iterator[Frame]:
    for k in range(count):
        yield episode.step(command if k else None)
    episode.close()


def bytes_of(frame: Frame) -> list[bytes]:
    held: list[Any] = [frame.observation.image_rgb, *(getattr(frame.truth, name) for name in meanings(FishTruth))]
    return [np.asarray(each).tobytes() for each in held]


@pytest.fixture(scope="module")
def seen() -> list[Frame]:
    """Return frames of a dozen fish in small pictures."""
    return list(frames(FISH_TANK.episode(SMALL, 5), 30))


def fish_truth(frame: Frame) -> FishTruth:
    assert isinstance(frame.truth, FishTruth)
    return frame.truth


def test_an_episode_is_the_same_bytes_again_and_another_seed_is_not(seen: list[Frame]) -> None:
    again = list(frames(FISH_TANK.episode(SMALL, 5), 4))
    other = list(frames(FISH_TANK.episode(SMALL, 6), 1))
    for first, second in zip(seen, again, strict=False):
        assert bytes_of(first) == bytes_of(second)
    assert bytes_of(seen[0])[0] != bytes_of(other[0])[0]


def test_truth_has_the_declared_shapes(seen: list[Frame]) -> None:
    for frame in seen:
        check_truth(frame.truth)
        truth = fish_truth(frame)
        assert ((truth.below_surface_m > 0) & (truth.below_surface_m < VOLUME_M[2])).all()


def wholly_seen(truth: FishTruth) -> Iterator[tuple[int, NDArray[np.int64]]]:
    """Yield the fish that nothing hides: their index, and the box of their pixels."""
    for k in np.flatnonzero((truth.state == "in") & (truth.visible_fraction > 0.97)).tolist():
        rows, columns = np.nonzero(truth.instance_map == truth.instance_id[k])
        yield k, np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1])


def share_on_body(truth: FishTruth, k: int, line_px: NDArray[np.float64]) -> float:
    """Return how much of a centre line, but for its thin ends, lies on the pixels of the fish."""
    columns, rows = np.floor(line_px[1:-2]).astype(int).T
    return float((truth.instance_map[rows, columns] == truth.instance_id[k]).mean())


def test_boxes_and_centre_lines_are_where_the_pixels_of_the_fish_are() -> None:
    """The map comes from the warped picture, boxes and lines from projection through the surface."""
    gaps = []
    for frame in frames(FISH_TANK.episode(dataclasses.replace(SMALL, width_px=640, height_px=480), 5), 10):
        truth = fish_truth(frame)
        for k, box in wholly_seen(truth):
            within = (box - truth.box_xyxy[k]) * (1, 1, -1, -1)
            # Ripples may show a tip twice; the tip of a tail may fall between the samples.
            assert within.min() > -2.0
            assert within.max() < 0.3 * np.ptp(truth.box_xyxy[k].reshape(2, 2), axis=0).max()
            gaps.append(within)
            assert share_on_body(truth, k, truth.centre_line_px[k]) > 0.8
    assert len(gaps) > 50
    # Pixels are sampled at their centres: boxes of samples are larger by less than half a pixel, on each side.
    assert np.abs(np.mean(gaps, axis=0)).max() < 0.5


def surface_like(surface: RippledSurface, waves: Waves, time_s: float) -> RippledSurface:
    other = RippledSurface(waves, surface.low_m, surface.high_m, surface.level_m, surface.depth_m)
    other.time_s = time_s
    return other


def test_truth_is_that_of_the_ripples_of_its_frame() -> None:
    """In rough water flat truth, and that of the next frame's ripples, fit the pixels clearly worse."""
    episode = FISH_TANK.episode(
        dataclasses.replace(SMALL, width_px=640, height_px=480, ripples=Ripples(slope_rms=0.1)), 5
    )
    off_px: dict[str, list[NDArray[np.float64]]] = {"own": [], "flat": [], "next": []}
    on_body: dict[str, list[float]] = {name: [] for name in off_px}
    for frame in frames(episode, 10):
        truth, camera, now = fish_truth(frame), frame.camera, episode._surface
        still = now.waves._replace(amplitude_m=np.zeros_like(now.waves.amplitude_m))
        others = {
            "flat": surface_like(now, still, now.time_s),
            "next": surface_like(now, now.waves, now.time_s + 1.0 / SMALL.rate_hz),
        }
        points_m = truth.centre_line_m.reshape(-1, 3)
        lines = {"own": truth.centre_line_px} | {
            name: project_through(other, camera, truth.T_world_camera, points_m).reshape(truth.centre_line_px.shape)
            for name, other in others.items()
        }
        for k, box in wholly_seen(truth):
            for name, line_px in lines.items():
                moved_px = (line_px[k] - truth.centre_line_px[k]).mean(axis=0)
                off_px[name].append((box - truth.box_xyxy[k]).reshape(2, 2).mean(axis=0) - moved_px)
                on_body[name].append(share_on_body(truth, k, line_px[k]))
    # Middles of boxes in x and y; a median, as ripples show some tips twice.
    off = {name: np.median(np.abs(each), axis=0) for name, each in off_px.items()}
    assert len(off_px["own"]) > 50
    assert (off["own"] < 0.4).all()
    assert np.mean(on_body["own"]) > 0.97
    for name in others:
        assert (off["own"] < 0.6 * off[name]).all(), name
        assert np.mean(on_body[name]) < 0.9, name


def test_headings_point_to_the_head_and_positions_to_the_middle(seen: list[Frame]) -> None:
    for frame in seen:
        truth = fish_truth(frame)
        ahead = truth.centre_line_px[:, 0] - truth.centre_line_px[:, 4]
        np.testing.assert_allclose(np.arctan2(ahead[:, 1], ahead[:, 0]), truth.heading_rad)
        np.testing.assert_array_equal(truth.position_px, truth.centre_line_px[:, 4])


def test_fish_swim_towards_their_heads(seen: list[Frame]) -> None:
    places = np.array([frame.truth.position_px for frame in seen])
    moved = places[5:] - places[:-5]
    ahead = np.array([(np.cos(fish_truth(f).heading_rad), np.sin(fish_truth(f).heading_rad)) for f in seen[2:-3]])
    along = (moved * ahead.transpose(0, 2, 1)).sum(axis=2)
    fast = np.linalg.norm(moved, axis=2) > 2.0
    assert fast.sum() > 30
    assert (along[fast] > 0).mean() > 0.95


def test_a_fish_is_hidden_by_one_above_it() -> None:
    episode = FISH_TANK.episode(dataclasses.replace(SMALL, fish=80, width_px=640, height_px=480), 1)
    hidden = above = 0
    for frame in frames(episode, 12):
        truth = fish_truth(frame)
        below = np.flatnonzero((truth.hidden_by >= 0) & (truth.visible_fraction < 0.8))
        hidden += len(below)
        above += int((truth.below_surface_m[truth.hidden_by[below]] < truth.below_surface_m[below]).sum())
    assert hidden > 10
    assert above > 0.9 * hidden


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["quick", "mixed", "round"])
def test_both_renderers_see_the_same_fish(name: str) -> None:
    preset = dataclasses.replace(PRESETS[name], fish=12, frame_count=30, width_px=320, height_px=240)
    first, second = (
        next(frames(FISH_TANK.episode(preset, 5, renderer=renderer), 1)).truth for renderer in ("raster", "pybullet")
    )
    ours, other = first.instance_map, second.instance_map
    is_fish = np.isin(ours, first.instance_id)
    inside = is_fish & _eroded(is_fish)
    assert inside.sum() > 40
    assert (ours[inside] == other[inside]).mean() > 0.97


def _eroded(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    inner = mask.copy()
    for axis in (0, 1):
        for shift in (-1, 1):
            inner &= np.roll(mask, shift, axis)
    return inner


def test_the_background_shows_the_tank_without_fish(seen: list[Frame]) -> None:
    episode = FISH_TANK.episode(SMALL, 5)
    start = episode.start
    episode.close()
    assert len(start.background) == 20
    assert all(each.time_s < 0 for each in start.background)
    empty = np.median([each.image_rgb for each in start.background], axis=0).mean(axis=2)
    first, truth = seen[0].observation.image_rgb.mean(axis=2), seen[0].truth
    is_fish = np.isin(truth.instance_map, truth.instance_id)
    assert np.abs(first - empty)[is_fish].mean() > 4 * np.abs(first - empty)[~is_fish].mean()
    assert start.box_xyxy is not None
    np.testing.assert_array_equal(start.box_xyxy, truth.box_xyxy[truth.index_of(FISH_TANK.target)])


def test_truth_of_the_target_alone_has_the_same_pictures() -> None:
    whole, alone = (list(frames(FISH_TANK.episode(SMALL, 5, truth=extent), 2)) for extent in ("all", "target"))
    for all_of_it, some in zip(whole, alone, strict=True):
        np.testing.assert_array_equal(all_of_it.observation.image_rgb, some.observation.image_rgb)
        np.testing.assert_array_equal(all_of_it.truth.box_xyxy, some.truth.box_xyxy)
        assert some.truth.visible_fraction[0] == all_of_it.truth.visible_fraction[0]
        assert np.isnan(some.truth.visible_fraction[1:]).all()


# The steered camera ---------------------------------------------------------------------------------------------------


def test_the_head_turns_towards_a_fish_and_judges_by_its_own_picture() -> None:
    episode = FISH_TANK.episode(dataclasses.replace(SMALL, frame_count=30), 5, closed_loop=True)
    frame = episode.step()
    for _ in range(29):
        assert frame.steered is not None
        check_truth(frame.steered)
        truth, camera = frame.judged
        x, y = truth.position_px[0] - 0.5 * np.array([camera.width_px, camera.height_px])
        command = CameraCommand(pan_rad_s=-8 * x / camera.focal_px, tilt_rad_s=-8 * y / camera.focal_px)
        frame = episode.step(command)
    truth, camera = frame.judged
    episode.close()
    assert np.abs(truth.position_px[0] - 0.5 * np.array([camera.width_px, camera.height_px])).max() < 40.0
    assert truth.state[0] == "in"
    away = truth.state == "out"
    assert away.any()
    x, y = truth.position_px[away].T
    assert ((x < 0) | (y < 0) | (x > camera.width_px) | (y > camera.height_px)).all()


def test_zoom_magnifies_and_stops_at_its_limit() -> None:
    episode = FISH_TANK.episode(dataclasses.replace(SMALL, frame_count=60), 5, closed_loop=True)
    focal_px = [episode.step().judged[1].focal_px]
    for _ in range(59):
        focal_px.append(episode.step(CameraCommand(zoom_per_s=5.0)).judged[1].focal_px)
    episode.close()
    assert (np.diff(focal_px) >= 0).all()
    assert focal_px[-1] == focal_px[-2] == pytest.approx(3.0 * focal_px[0])
    # The rate itself changes no faster than its slew allows.
    assert focal_px[1] < focal_px[0] * 1.02


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fish": 0}, r"fish: expected a number in \[1, 150\], got 0"),
        ({"variety": 1.5}, r"variety: expected a number in \[0, 1\], got 1.5"),
        ({"width_px": "wide"}, "width_px: expected int, got 'wide'"),
        ({"rate_hz": 0.0}, r"rate_hz: expected a number in \[0.01, 1000\]"),
    ],
)
def test_unfit_configurations_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(SMALL, **change)


def test_the_whole_tank_is_in_a_wide_picture() -> None:
    episode = FISH_TANK.episode(dataclasses.replace(PRESETS["quick"], width_px=320, height_px=120, fish=12), 0)
    states = {str(state) for _ in range(3) for state in episode.step().truth.state}
    episode.close()
    assert states == {"in"}


@pytest.mark.heavy
def test_as_many_fish_as_a_preset_may_have_find_room() -> None:
    episode = FISH_TANK.episode(dataclasses.replace(PRESETS["hard"], fish=150, frame_count=2), 0)
    assert len(episode.step().truth.names) >= 150
    episode.close()


@pytest.mark.parametrize("change", [{"cruise_mps": float("nan")}, {"glide_s": 0.0}, {"mood_s": float("inf")}])
def test_an_impossible_character_is_named(change: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=f"character.{next(iter(change))}: expected"):
        FISH_TANK.episode(dataclasses.replace(PRESETS["quick"], character=ZEBRAFISH._replace(**change)), 0)


@pytest.mark.heavy
def test_what_counts_as_glare_is_what_the_water_mirrors_of_lamps() -> None:
    """Bright pixels are those to which mirror images add, and all to which they add three times the floor's light."""
    preset = dataclasses.replace(PRESETS["mixed"], glare=1.0, lamp=0.3)
    bright, strong = [], []
    for seed in range(2):
        episode = FISH_TANK.episode(preset, seed)
        for frame in frames(episode, 2):
            shader, camera, pose = episode._shader, frame.camera, frame.truth.T_world_camera
            seen = episode._camera._renderer.gbuffer(camera, pose)
            whole = shader.shade(seen, camera, pose)
            nit = shader._panels.nit.copy()
            shader._panels.nit[:] = 0.0
            mirrored = (whole - shader.shade(seen, camera, pose)).min(axis=1) / np.median(whole)
            shader._panels.nit[:] = nit
            is_bright = frame.observation.image_rgb.min(axis=2) >= 200
            bright.append(mirrored[is_bright])
            strong.append(is_bright[mirrored > 3.0])
    assert np.concatenate(strong).sum() > 300
    assert (np.concatenate(bright) > 0.3).mean() > 0.97
    assert np.concatenate(strong).mean() > 0.97


@pytest.mark.heavy
def test_glare_covers_the_share_of_a_fish_that_the_picture_shows_as_bright_as_a_lamp() -> None:
    preset = dataclasses.replace(PRESETS["hard"], width_px=320, height_px=240)
    episode = FISH_TANK.episode(preset, 3)
    most = 0.0
    for _ in range(12):
        frame = episode.step()
        truth, is_bright = frame.truth, frame.observation.image_rgb.min(axis=2) >= 200
        for number, share in zip(truth.instance_id, truth.glare_fraction, strict=True):
            own = truth.instance_map == number
            assert share == pytest.approx(is_bright[own].mean() if own.any() else 0.0)
        most = max(most, float(truth.glare_fraction.max()))
    assert most > 0.0


def test_leaves_hide_fish_as_the_picture_shows_and_no_fish_is_named_for_it() -> None:
    """Fish swim alike with and without leaves, so that the maps of both tell what leaves hide."""
    preset = dataclasses.replace(PRESETS["mixed"], width_px=320, height_px=240, frame_count=20, ripples=Ripples(0.003))
    shown: list[list[NDArray[np.float64]]] = []
    hidden = []
    for leaves in (0, 120):
        counts = []
        for frame in frames(FISH_TANK.episode(dataclasses.replace(preset, leaves=leaves), 2), 8):
            truth = fish_truth(frame)
            pixels = np.array([(truth.instance_map == number).sum() for number in truth.instance_id])
            counts.append(np.stack([pixels, truth.visible_fraction]))
            hidden.append(truth)
        shown.append(counts)
    open_px, open_share = np.concatenate(shown[0], axis=1)
    left_px, left_share = np.concatenate(shown[1], axis=1)
    large = (open_px > 40) & (open_share > 0.95)
    np.testing.assert_allclose(left_share[large], left_px[large] / open_px[large], atol=0.15)
    assert (left_share[large] < 0.45).any()
    assert (left_share[large] > 0.9).any()
    assert all(((truth.hidden_by >= -1) & (truth.hidden_by < len(truth.names))).all() for truth in hidden)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"species": ()}, r"species: expected one at least, got \(\)"),
        ({"species": ("shark",)}, r"species: expected tuple"),
        ({"tank_shape": "round"}, r"tank_m: expected a round tank's length and width alike"),
        ({"tank_m": (3.0, 0.4, 0.1)}, r"tank_m: expected length and width within \[0.2, 2\]"),
    ],
)
def test_unfit_tanks_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(SMALL, **change)
