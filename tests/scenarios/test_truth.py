"""Fields of truth match their meanings in every scenario, and so does all that derives from them."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from scenarios import catalog
from scenarios.envs.reward import TERMS
from scenarios.envs.truth_info import INFO, NO_REWARD, truth_info, truth_keys
from scenarios.scenario import Frame
from scenarios.truth import (
    TruthExtent,
    VisibilityState,
    check_truth,
    dtype_of,
    meanings,
    without_pixels,
    without_standing,
)
from scenarios.visibility import states_of
from trackers.types import CameraCommand, CameraModel, Estimate

FRAMES, SEED = 24, 3


@dataclass(frozen=True)
class Kind:
    """One kind of configuration of a scenario; each may have its own truth and its own way to leave fields out."""

    scenario: str
    preset: str

    def frames(self, extent: TruthExtent) -> list[Frame]:
        """Return the first frames of an episode."""
        return _frames(self, extent)


def _frames(kind: Kind, extent: TruthExtent) -> list[Frame]:
    return _episode(kind, extent)[1]


@cache
def _episode(kind: Kind, extent: TruthExtent) -> tuple[Any, list[Frame]]:
    episode = catalog.scenario(kind.scenario).episode(kind.preset, SEED, truth=extent)
    frames = [episode.step() for _ in range(min(FRAMES, episode.frame_count))]
    episode.close()
    return episode, frames


def presets_of(scenario: str) -> list[str]:
    """Return the names of a scenario's presets."""
    return list(catalog.scenario(scenario).presets)


def _kinds() -> list[Kind]:
    """Return the kinds of all scenarios but those of tests; the preset ``quick`` stands for its kind."""
    kinds = []
    for entry in catalog._ENTRIES:
        if entry.place.startswith("scenarios."):
            presets = catalog.scenario(entry.id).presets
            first = {type(presets[name]): name for name in sorted(presets, key=lambda name: name == "quick")}
            kinds += [Kind(entry.id, name) for name in first.values()]
    return kinds


each_kind = pytest.mark.parametrize("kind", _kinds(), ids=lambda kind: f"{kind.scenario}:{kind.preset}")
each_extent = pytest.mark.parametrize("extent", get_args(TruthExtent))


def assert_equal(ours: Any, theirs: Any, name: str) -> None:
    """Compare two values of a field, NaN equal to NaN."""
    if dataclasses.is_dataclass(ours):
        for field in dataclasses.fields(ours):
            assert_equal(getattr(ours, field.name), getattr(theirs, field.name), f"{name}.{field.name}")
    else:
        np.testing.assert_array_equal(ours, theirs, err_msg=name)


LABELLED = {
    "road-town-v2": {"vehicle"},
    "stereo-follow-v2": {"person"},
    "fish-tank-v1": {"fish"},
    "harbour-v1": {"person", "car", "boat", "parked", "moored"},
    "paper-sheet-v1": {"sheet"},
}
LABELLED["road-town-v3"] = {"vehicle", "passer-by"}
LABELLED |= {"fish-tank-ptz-v1": LABELLED["fish-tank-v1"], "harbour-ptz-v1": LABELLED["harbour-v1"]}
"""Categories of bodies that are of a labelled class."""
BACKGROUND = {
    "ground",
    "building",
    "tree",
    "kerb",
    "wood",
    "hedge",
    "wall",
    "furniture",
    "sea",
    "rope",
    "bird",
    "land",
    "props",
}
TINY = {"width_px": 64, "height_px": 48, "background": 0}


def assert_all_are_labelled(scenario: str, episode: Any, truths: list[Any]) -> int:
    """Compare every body that a picture shows with the truth; return how many stand about."""
    standing = 0
    for truth in truths:
        known = {*truth.instance_id.tolist(), *truth.standing_id.tolist()}
        seen = {k for k in np.unique(truth.instance_map).tolist() if k >= 0}
        for body in (episode.world.bodies[k] for k in seen):
            assert body.category in LABELLED[scenario] | BACKGROUND
            # A mooring has its buoy, which is no boat.
            is_labelled = body.category in LABELLED[scenario] and body.name != "buoy"
            assert (body.index in known) == is_labelled, body.name
        assert set(truth.standing_id.tolist()) <= seen
        assert not set(truth.standing_id.tolist()) & set(truth.instance_id.tolist())
        classes = catalog.scenario(scenario).classes
        assert set(truth.kinds) | set(truth.standing_kinds) <= set(classes)
        standing += len(truth.standing_id)
    return standing


@each_kind
def test_every_seen_body_of_a_labelled_class_is_an_object_or_stands_about(kind: Kind) -> None:
    episode, frames = _episode(kind, "all")
    standing = assert_all_are_labelled(kind.scenario, episode, [frame.truth for frame in frames])
    assert (standing > 0) == (kind.scenario in ("road-town-v2", "road-town-v3", "harbour-v1", "harbour-ptz-v1"))


@pytest.mark.heavy
@pytest.mark.parametrize(("scenario", "preset"), [(each, name) for each in LABELLED for name in presets_of(each)])
def test_so_it_is_in_every_preset(scenario: str, preset: str) -> None:
    configuration = catalog.scenario(scenario).presets[preset]
    tiny = replace(configuration, **{name: value for name, value in TINY.items() if hasattr(configuration, name)})
    episode = catalog.scenario(scenario).episode(tiny, SEED, closed_loop=False)
    assert_all_are_labelled(scenario, episode, [episode.step().truth for _ in range(2)])
    episode.close()


def test_parked_cars_of_the_town_are_named_and_their_boxes_hold_their_pixels() -> None:
    frames = _frames(Kind("road-town-v2", "quick"), "all")
    truths = [frame.truth for frame in frames if len(frame.truth.standing_id)]
    assert truths
    for truth in truths:
        assert all(name.startswith("parked-") for name in truth.standing_names)
        for k, number in enumerate(truth.standing_id):
            rows, columns = np.nonzero(truth.instance_map == number)
            x_min, y_min, x_max, y_max = truth.standing_box_xyxy[k]
            assert (columns + 1 > x_min).all()
            assert (columns < x_max).all()
            assert (rows + 1 > y_min).all()
            assert (rows < y_max).all()


@pytest.mark.parametrize("scenario", ["road-town-v2", "stereo-follow-v2", "harbour-v1"])
def test_bounds_hold_every_pixel_of_a_posed_body(scenario: str) -> None:
    """Pixels are taken back into the world by depth; those of the tank's fish have come through water."""
    seen = 0
    for frame in _frames(Kind(scenario, "quick"), "all"):
        truth, camera = frame.truth, frame.camera
        bodies = zip(
            [*truth.instance_id, *truth.standing_id],
            [*truth.T_world_object, *truth.T_world_standing],
            [*truth.bounds_m, *truth.standing_bounds_m],
            strict=True,
        )
        for number, T_world_body, (low_m, high_m) in bodies:
            rows, columns = np.nonzero(truth.instance_map == number)
            depth_m = truth.depth_m[rows, columns].astype(float)
            x_px, y_px = camera.centre_px
            rays = np.stack([(columns + 0.5 - x_px), (rows + 0.5 - y_px), np.full(len(rows), camera.focal_px)], axis=1)
            in_camera = rays * (depth_m / camera.focal_px)[:, None]
            T_body_camera = np.linalg.inv(T_world_body) @ truth.T_world_camera
            points_m = in_camera @ T_body_camera[:3, :3].T + T_body_camera[:3, 3]
            assert (points_m > low_m - 0.02).all()
            assert (points_m < high_m + 0.02).all()
            seen += len(points_m) > 0
    assert seen > 10


def test_bounds_hold_a_fish_that_bends() -> None:
    frames = _frames(Kind("fish-tank-v1", "quick"), "all")
    bent = False
    for truth in (frame.truth for frame in frames):
        to_fish = np.linalg.inv(truth.T_world_object)
        line_m = np.einsum("nij,nkj->nki", to_fish[:, :3, :3], truth.centre_line_m) + to_fish[:, None, :3, 3]
        assert (line_m > truth.bounds_m[:, None, 0] - 1e-4).all()
        assert (line_m < truth.bounds_m[:, None, 1] + 1e-4).all()
        bent |= bool((truth.bounds_m[:, 1, 1] - truth.bounds_m[:, 0, 1] > 1.5 * truth.size_m[:, 1]).any())
    assert bent


def test_who_walks_is_longer_than_who_stands() -> None:
    truth = _frames(Kind("stereo-follow-v2", "quick"), "all")[-1].truth
    length_m = truth.bounds_m[:, 1, 0] - truth.bounds_m[:, 0, 0]
    assert (length_m > 1.3 * truth.size_m[:, 0]).any()


def test_truth_made_without_bounds_has_those_of_its_sizes() -> None:
    truth = _frames(Kind("stereo-follow-v2", "quick"), "all")[0].truth
    made = replace(truth, bounds_m=np.empty((0, 2, 3)))
    np.testing.assert_allclose(made.bounds_m[:, 1] - made.bounds_m[:, 0], made.size_m)
    np.testing.assert_allclose(made.bounds_m[:, 0], made.size_m * (-0.5, -0.5, 0.0))


def test_another_camera_has_nothing_that_stands_about() -> None:
    truth = _frames(Kind("harbour-v1", "quick"), "all")[0].truth
    assert len(truth.standing_id) > 0
    less = without_standing(truth)
    check_truth(less)
    assert less.standing_names == ()
    assert len(less.standing_box_xyxy) == 0
    assert less.names == truth.names


def test_what_is_in_is_at_least_half_seen_and_whole_within_the_borders() -> None:
    boxes = np.array([[0.0, 0.0, 10.0, 10.0]] * 3 + [[-1.0, 0.0, 10.0, 10.0]])
    camera = CameraModel(64, 48, 60.0)
    states = states_of(camera, boxes, np.array([1.0, 0.51, 0.49, 1.0]))
    assert states.tolist() == ["in", "in", "occluded", "partial"]


@pytest.mark.heavy
@each_kind
@each_extent
def test_truth_is_what_its_fields_say(kind: Kind, extent: TruthExtent) -> None:
    for frame in kind.frames(extent):
        check_truth(frame.truth)
        for name, meaning in meanings(frame.truth).items():
            value = getattr(frame.truth, name)
            if isinstance(value, np.ndarray) and meaning.unit != "word":
                assert value.dtype == dtype_of(type(frame.truth), name), name
        assert set(frame.truth.state.tolist()) <= set(get_args(VisibilityState))
        assert len(set(frame.truth.names)) == len(frame.truth.names)


@pytest.mark.heavy
@each_kind
def test_what_is_left_out_is_what_says_so_and_nothing_else_differs(kind: Kind) -> None:
    name_of_target = catalog.scenario(kind.scenario).target
    for whole, less in zip(kind.frames("all"), kind.frames("target"), strict=True):
        assert_equal(whole.observation, less.observation, "observation")
        target = whole.truth.index_of(name_of_target)
        others = np.arange(len(whole.truth.names)) != target
        for name, meaning in meanings(whole.truth).items():
            held, left = getattr(whole.truth, name), getattr(less.truth, name)
            if not meaning.left_out:
                if name != "state":
                    assert_equal(held, left, name)
            elif meaning.per_pixel:
                assert held.shape[:2] == whole.observation.image_rgb.shape[:2]
                assert (left.shape, left.dtype) == ((0, 0, *held.shape[2:]), held.dtype)
            elif meaning.table == "standing":
                assert len(left) == 0
            else:
                assert_equal(held[target], left[target], name)
                if held.dtype.kind == "f":
                    assert not np.isnan(held[others]).any()
                    assert np.isnan(left[others]).all()
                else:
                    assert (left[others] == -1).all()
        # The state of the others follows from their boxes alone.
        by_boxes = states_of(whole.camera, whole.truth.box_xyxy, np.full(len(others), np.nan))
        by_boxes[whole.truth.state == "absent"] = "absent"
        assert_equal(np.where(others, by_boxes, whole.truth.state), less.truth.state, "state")


@each_kind
def test_stripping_takes_what_is_per_pixel_and_nothing_else(kind: Kind) -> None:
    truth = kind.frames("all")[0].truth
    stripped = without_pixels(truth)
    check_truth(stripped)
    assert type(stripped) is type(truth)
    pixels = truth.instance_map.shape
    for name, meaning in meanings(truth).items():
        was, now = getattr(truth, name), getattr(stripped, name)
        assert meaning.per_pixel == (np.shape(was)[:2] == pixels)
        if meaning.per_pixel:
            assert (now.shape, now.dtype) == ((0, 0, *was.shape[2:]), was.dtype)
        else:
            assert now is was, name


@each_kind
def test_another_shape_is_refused_by_name(kind: Kind) -> None:
    truth = kind.frames("all")[0].truth
    for name in meanings(truth):
        value = np.asarray(getattr(truth, name))
        with pytest.raises(ValueError, match=rf"^{name}: expected the shape \(.*\), got \("):
            check_truth(replace(truth, **{name: value[None]}))
        if value.size and value.ndim and name not in ("names", "standing_names", "instance_map"):
            with pytest.raises(ValueError, match=rf"^{name}: expected the shape \(.*\), got \("):
                check_truth(replace(truth, **{name: np.repeat(value, 2, axis=0)}))
    for changes in ({"names": (*truth.names, "one more")}, {"instance_map": truth.instance_map[1:]}):
        with pytest.raises(ValueError, match=r": expected the shape \(.*\), got \("):
            check_truth(replace(truth, **changes))


@each_kind
@pytest.mark.parametrize("share", [-0.01, 1.01, np.inf])
def test_a_share_beyond_its_range_is_refused_by_name(kind: Kind, share: float) -> None:
    truth = kind.frames("all")[0].truth
    fractions = [name for name, meaning in meanings(truth).items() if meaning.unit == "fraction"]
    own = ["snow_cover"] if hasattr(truth, "snow_cover") else []
    assert fractions == ["visible_fraction", "glare_fraction", "standing_visible_fraction", *own]
    shares = np.append(np.full(len(truth.names) - 1, np.nan), share)
    message = f"^visible_fraction: expected numbers from 0 to 1, got {share:g} to {share:g}$"
    with pytest.raises(ValueError, match=message):
        check_truth(replace(truth, visible_fraction=shares))
    check_truth(replace(truth, visible_fraction=np.full(len(shares), np.nan)))


@each_kind
def test_an_object_that_there_is_not_is_refused_by_name(kind: Kind) -> None:
    truth = kind.frames("all")[0].truth
    assert [truth.index_of(name) for name in truth.names] == list(range(len(truth.names)))
    with pytest.raises(ValueError, match=rf"^object: expected one of {truth.names[0]}.*; got 'nothing'"):
        truth.index_of("nothing")


@each_kind
def test_info_tells_every_number_of_every_truth_but_those_per_pixel(kind: Kind) -> None:
    frame = kind.frames("all")[-1]
    truth, target = frame.truth, len(frame.truth.names) - 1
    held = truth_info(frame, target, (frame, Estimate(np.zeros(2))), CameraCommand(), NO_REWARD, SEED)
    rest = {"episode_seed", "world_seed", "in_view", "centring", "length_px", "place_m", "error_px", "command"}
    rest |= {f"reward_{term}" for term in TERMS}
    expected = {"state": get_args(VisibilityState).index(truth.state[target])}
    kind: Any = type(truth)
    keys = INFO | truth_keys(kind)
    for field in dataclasses.fields(truth):
        value = np.asarray(getattr(truth, field.name))
        if value.dtype.kind in "biuf" and meanings(truth)[field.name].table in ("objects", "frames"):
            meaning, words = meanings(truth)[field.name], keys[field.name][2]
            expected[field.name] = value[target] if meaning.table == "objects" else value
            assert (meaning.unit in words.split(", ")) == (meaning.unit != "1")
            assert meaning.coding.replace("NaN", "inf") in words
    assert set(keys) == set(held) == rest | set(expected)
    for name, value in expected.items():
        # Checkers of envs compare infos, and a NaN equals no other.
        without_nan = np.where(np.isnan(value), np.inf, value) if np.asarray(value).dtype.kind == "f" else value
        assert_equal(held[name], without_nan, name)
        assert not (isinstance(held[name], np.ndarray) and np.shares_memory(held[name], getattr(truth, name)))


def test_no_judge_and_no_tracker_names_a_field_that_is_not_judged() -> None:
    """Canaries leave these fields out, so rows must not follow from them."""
    root = Path(__file__).parents[2]
    fields = {name for each in LABELLED for name, m in meanings(catalog.scenario(each).truth).items() if not m.judged}
    assert {"bounds_m", "glare_fraction", "standing_id"} <= fields
    word = re.compile(rf"\b({'|'.join(sorted(fields))})\b")
    rooms = ("contract", "statistics", "judges", "run", "papers", "learning")
    for folder in (*(f"benchmarks/{room}" for room in rooms), "trackers", "scenarios/envs"):
        for path in (root / folder).rglob("*.py"):
            assert not word.search(path.read_text(encoding="utf-8")), path
