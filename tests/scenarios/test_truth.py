"""Fields of truth match their meanings in every scenario, and so does all that derives from them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, replace
from functools import cache
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
)
from scenarios.visibility import states_of
from trackers.types import CameraCommand, Estimate

FRAMES, SEED = 24, 3


@dataclass(frozen=True)
class Kind:
    """One kind of configuration of a scenario; each may have its own truth and its own way to leave fields out."""

    scenario: str
    preset: str

    def frames(self, extent: TruthExtent) -> list[Frame]:
        """Return the first frames of an episode."""
        return _frames(self, extent)


@cache
def _frames(kind: Kind, extent: TruthExtent) -> list[Frame]:
    episode = catalog.scenario(kind.scenario).episode(kind.preset, SEED, truth=extent)
    frames = [episode.step() for _ in range(min(FRAMES, episode.frame_count))]
    episode.close()
    return frames


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
            elif meaning.per_standing:
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
    assert fractions == ["visible_fraction", "standing_visible_fraction"]
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
    held = truth_info(frame, target, Estimate(np.zeros(2)), CameraCommand(), NO_REWARD, SEED)
    rest = {"episode_seed", "world_seed", "in_view", "centring", "length_px", "place_m", "error_px", "command"}
    rest |= {f"reward_{term}" for term in TERMS}
    expected = {"state": get_args(VisibilityState).index(truth.state[target])}
    kind: Any = type(truth)
    keys = INFO | truth_keys(kind)
    for field in dataclasses.fields(truth):
        value = np.asarray(getattr(truth, field.name))
        if value.dtype.kind in "biuf" and meanings(truth)[field.name].table in ("objects", "frames"):
            meaning, words = meanings(truth)[field.name], keys[field.name][2]
            expected[field.name] = value[target] if meaning.per_object else value
            assert (meaning.unit in words.split(", ")) == (meaning.unit != "1")
            assert meaning.coding.replace("NaN", "inf") in words
    assert set(keys) == set(held) == rest | set(expected)
    for name, value in expected.items():
        # Checkers of envs compare infos, and a NaN equals no other.
        without_nan = np.where(np.isnan(value), np.inf, value) if np.asarray(value).dtype.kind == "f" else value
        assert_equal(held[name], without_nan, name)
        assert not (isinstance(held[name], np.ndarray) and np.shares_memory(held[name], getattr(truth, name)))
