"""Settings of an env are checked when it is made, with messages that name the fault."""

from __future__ import annotations

import dataclasses
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios import catalog
from scenarios.command_link import Link
from scenarios.envs.settings import OWN_WORLD, RESET_OPTIONS, FollowSettings, between
from scenarios.road_town.presets import PRESETS
from trackers.follow_one import FollowOne

STANDARD, HARD = PRESETS["standard"], PRESETS["hard"]


def settings(**changes: Any) -> FollowSettings:
    return FollowSettings("road-town-v2", **{"tracker": "hold", **changes})


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("preset", "easy", "preset: expected one of .*; got 'easy'"),
        ("observation", "sound", "observation: expected one of track, pixels, depth, segmentation, both; got 'sound'"),
        (
            "observation",
            ("track", "both"),
            "observation: expected one of track, pixels, depth, segmentation; got 'both'",
        ),
        ("observation", ["depth", "depth"], r"observation: expected each channel once, got \['depth', 'depth'\]"),
        ("observation", (), r"observation: expected a channel, or several, got \(\)"),
        ("observation", 3, "observation: expected a channel, or several, got 3"),
        ("observation", "pixel", r"got 'pixel' \(did you mean pixels\?\)"),
        ("preset", "quik", r"preset: .*got 'quik' \(did you mean quick\?\)"),
        ("changes", {"widht_px": 84}, r"changes: .*got 'widht_px' \(did you mean width_px\?\)"),
        ("action", "thought", "action: expected one of command, correction, parameters"),
        ("renderer", "paint", "renderer: expected one of raster, pybullet"),
        ("corrects", "never", "corrects: expected one of always, unseen"),
        ("correction_share", 0.0, "correction_share: expected a number in"),
        (
            "controller",
            "reentry",
            "controller: expected none with action='command', as it is of correction",
        ),
        ("controller_values", {"a": 1}, "controller_values: expected none with action='command'"),
        ("corrects", "unseen", "corrects: expected none with action='command', as it is of correction, got 'unseen'"),
        ("correction_share", 0.1, "correction_share: expected none with action='command'"),
        ("reward", 1, "reward: expected a Reward, or a mapping of its fields, got 1"),
        ("reward", {"in_vew": 1}, r"reward: expected one of in_view, .*; got 'in_vew' \(did you mean in_view\?\)"),
        ("reward", {"effort": "x"}, "reward.effort: expected a finite number, got 'x'"),
        ("reward", {"loss_after_s": 0}, "reward.loss_after_s: expected a finite number > 0, got 0"),
        ("lost_after_s", -1.0, "lost_after_s: expected None or a number > 0, got -1"),
        ("lost_after_s", "a", "lost_after_s: expected None or a number > 0, got 'a'"),
        ("link", {}, "link: expected one of prompt, delayed, noisy, late or a Link, got {}"),
        ("preset", [], r"preset: expected one of .*; got \[\]"),
        ("tracker", "owl", "tracker: expected one of .*; got 'owl'"),
        ("tracker", 3, "tracker: expected None, the name of a tracker, or an object with initialise and update, got 3"),
        ("tracker", FollowOne, "tracker: expected None, .* or an object with initialise and update, got <class"),
        ("worlds", -1, "worlds: expected None or a whole number >= 0, got -1"),
        ("worlds", True, "worlds: expected None or a whole number >= 0, got True"),
        ("changes", 3, "changes: expected a dictionary, got 3"),
        ("randomise", {"ego": (0, 1)}, "randomise: expected fields that are numbers, got 'ego'"),
        ("randomise", {"width_px": 3}, "randomise.width_px: expected two numbers in ascending order, or two .*, got 3"),
        (
            "randomise",
            {"frame_count": (-5, 300)},
            "frame_count: expected at least 107 for 2 or more frame-outs, got -5",
        ),
        ("link", "slow", "link: expected one of prompt, delayed, noisy, late or a Link, got 'slow'"),
        ("difficulty", 1.5, "difficulty: expected None or a number from 0 to 1, got 1.5"),
        ("changes", {"traffic_cars": 61}, r"traffic_cars: expected a number in \[0, 60\], got 61"),
        ("randomise", {"traffic_cars": (3, 400)}, r"traffic_cars: expected a number in \[0, 60\], got 400"),
        ("changes", {"wheels": 3}, "changes: expected one of .*, traffic_cars, .*; got 'wheels'"),
        ("changes", {"width_px": 3}, "width_px: expected a whole number from 32 to 4096, got 3"),
        ("changes", {"altitude_m": 60}, r"altitude_m: expected tuple\[float, float\], got 60"),
        (
            "changes",
            {"altitude_m": (80, 50)},
            r"altitude_m: expected two numbers in ascending order in \[40, 100\], got",
        ),
        ("changes", {"altitude_m": (50, np.nan)}, r"altitude_m: expected tuple\[float, float\], got \(50, nan\)"),
        ("changes", {"excursions": (2, 1)}, r"excursions: expected two numbers in ascending order in \[0, 10\], got"),
        ("changes", {"turn_preference": 0}, r"turn_preference: expected a number in \(0, 1e\+06\], got 0"),
        ("changes", {"rate_hz": 0}, r"rate_hz: expected a number in \[0.01, 1000\], got 0"),
        ("changes", {"extent_m": 2000}, r"extent_m: expected a number in \[300, 1600\), got 2000"),
        ("changes", {"traffic_looks": "cows"}, "traffic_looks: expected one of others, twins; got 'cows'"),
        ("changes", {"street_patterns": ("nix",)}, r"street_patterns: expected some of grid, .*, got \('nix',\)"),
        ("changes", {"street_patterns": "grid"}, "street_patterns: expected tuple.*, got 'grid'"),
        ("changes", {"frame_outs": 3}, "frame_outs: expected FrameOuts, got 3"),
        ("changes", {"ego": 3}, r"ego: expected EgoErrors \| None, got 3"),
        ("changes", {"frame_count": 100}, "frame_count: expected at least 107 for 2 or more frame-outs, got 100"),
        ("changes", {"frame_count": 120.5}, "frame_count: expected int, got 120.5"),
        ("randomise", {"wheels": (1, 2)}, "randomise: expected one of .*, traffic_cars, .*; got 'wheels'"),
        ("randomise", {"attitude_noise_deg": (2, 1)}, "randomise.attitude_noise_deg: expected two numbers in asc"),
    ],
)
def test_what_is_wrong_is_named(name: str, value: Any, expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        settings(**{name: value})


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"lamps_off_s": 3}, r"lamps_off_s: expected tuple\[float, float\], got 3"),
        ({"crossers": "three"}, "crossers: expected int, got 'three'"),
        ({"odometry": "yes"}, "odometry: expected bool, got 'yes'"),
        ({"frame_count": 1}, r"frame_count: expected a whole number in \[2, 900\], as an episode lasts 60 s .*, got 1"),
        ({"width_px": 100_000}, "width_px: expected a whole number from 32 to 4096, got 100000"),
    ],
)
def test_what_is_wrong_with_a_person_to_follow_is_named_too(changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        FollowSettings("stereo-follow-v2", "hold", changes=changes)


def test_numbers_of_numpy_and_lists_are_taken() -> None:
    changes = {"width_px": np.int64(84), "rate_hz": np.float32(10), "altitude_m": [50, 80], "ego": None}
    assert settings(changes=changes).configuration({}).width_px == 84


def test_what_is_observed_keeps_its_size() -> None:
    with pytest.raises(ValueError, match="randomise: expected no size of the picture where that is observed"):
        settings(observation="pixels", randomise={"width_px": (64, 128)})
    settings(observation="track", randomise={"width_px": (64, 128)})


def test_the_world_of_an_episode_follows_from_its_seed_alone() -> None:
    assert [settings(worlds=3).world_of(seed) for seed in range(5)] == [0, 1, 2, 0, 1]
    assert [settings().world_of(seed) for seed in (3, 16, 9_999)] == [3, 0, 15]
    assert [settings().world_of(seed) for seed in (10_000, 12_345)] == [OWN_WORLD, OWN_WORLD]
    assert settings(worlds=0).world_of(3) == FollowSettings("fish-tank-v1", "hold").world_of(3) == OWN_WORLD


def test_worlds_are_kept_where_that_is_possible() -> None:
    able = r"expected a scenario that keeps worlds \(road-town-v2, .*stereo-follow-v2\), got fish-tank-v1"
    with pytest.raises(ValueError, match=f"worlds: {able}"):
        FollowSettings("fish-tank-v1", "hold", worlds=1)
    with pytest.raises(ValueError, match=f"world_seed: {able}"):
        FollowSettings("fish-tank-v1", "hold").with_options({"episode_seed": 1, "world_seed": 1})
    with pytest.raises(ValueError, match="world_seed: expected an episode_seed beside it, got none"):
        settings().with_options({"world_seed": 1})
    with pytest.raises(ValueError, match=r"world_seed: expected a whole number >= 0, or -1 .* got -2"):
        settings().with_options({"episode_seed": 1, "world_seed": -2})
    for of in (settings(), FollowSettings("fish-tank-v1", "hold")):
        of.with_options({"episode_seed": 1, "world_seed": OWN_WORLD})


def test_an_unknown_scenario_is_refused() -> None:
    with pytest.raises(ValueError, match="scenario: expected one of"):
        FollowSettings("moon-v1", "hold")


def test_options_change_one_episode_alone() -> None:
    mine = settings(preset="quick")
    other = mine.with_options({"preset": "hard", "link": Link(delay_frames=1), "episode_seed": 3})
    assert (other.preset, other.link_settings.delay_frames) == ("hard", 1)
    assert mine.preset == "quick"
    assert mine.with_options({}) is mine
    with pytest.raises(ValueError, match=f"options: expected keys among {', '.join(RESET_OPTIONS)}, got 'colour'"):
        mine.with_options({"colour": 1})


@given(st.floats(0, 1))
def test_difficulty_lies_between_the_presets(difficulty: float) -> None:
    preset = between(STANDARD, HARD, difficulty)
    assert STANDARD.attitude_noise_deg <= preset.attitude_noise_deg <= HARD.attitude_noise_deg
    assert STANDARD.traffic_cars <= preset.traffic_cars <= HARD.traffic_cars
    assert isinstance(preset.traffic_cars, int)
    assert preset.traffic_looks in (STANDARD.traffic_looks, HARD.traffic_looks)


def test_lists_are_taken_for_tuples_as_json_has_no_tuples() -> None:
    listed, tupled = (
        FollowSettings("road-town-v2", "hold", preset="quick", changes=changes).configuration({})
        for changes in (
            {"altitude_m": [50.0, 60.0], "street_patterns": ["grid"]},
            {"altitude_m": (50.0, 60.0), "street_patterns": ("grid",)},
        )
    )
    assert listed == tupled
    assert hash(listed) == hash(tupled)


@pytest.mark.parametrize("difficulty", ["a", True, -0.1, 1.1])
def test_a_difficulty_is_a_number_from_0_to_1(difficulty: Any) -> None:
    with pytest.raises(ValueError, match="difficulty: expected None or a number from 0 to 1, got "):
        settings(difficulty=difficulty)


def test_a_drawn_value_holds_where_the_field_is_changed_too() -> None:
    both = settings(changes={"traffic_cars": 3}, randomise={"traffic_cars": (4, 24)})
    assert both.configuration({}).traffic_cars == 3
    assert both.configuration({"traffic_cars": 7.0}).traffic_cars == 7


# Other tests register scenes of their own in the same process.
OURS = [each for each in catalog.entries() if each.env_id and each.place.startswith("scenarios.")]


GRADED = [each for each in OURS if "hard" in catalog.scenario(each.id).presets]


@pytest.mark.parametrize("entry", GRADED, ids=lambda each: each.id)
def test_envs_have_difficulties(entry: catalog.Entry) -> None:
    presets = catalog.scenario(entry.id).presets
    easy, hard = presets["standard"], presets["hard"]
    for difficulty in (0.0, 0.03, 0.21, 0.5, 0.97, 1.0):
        made = FollowSettings(entry.id, entry.tracker, difficulty=difficulty).configuration({})
        for name in (field.name for field in dataclasses.fields(easy)):
            low, high, value = (getattr(preset, name) for preset in (easy, hard, made))
            assert type(value) is type(low)
            if difficulty in (0.0, 1.0) or low == high:
                assert value == (high if difficulty == 1.0 else low), name


def test_difficulty_ends_at_the_presets() -> None:
    assert between(STANDARD, HARD, 0.0) == STANDARD
    assert between(STANDARD, HARD, 1.0) == HARD
    assert settings(difficulty=1.0).configuration({}) == HARD


def test_preset_and_difficulty_together_are_refused() -> None:
    """Even where they agree: which of the two holds is not to be guessed."""
    told = "difficulty: expected no preset beside it, .*, got preset='standard' and difficulty=0.0"
    with pytest.raises(ValueError, match=told):
        settings(preset="standard", difficulty=0.0)
    for made in (settings(), settings(preset="quick"), settings(difficulty=1.0)):
        with pytest.raises(ValueError, match=told):
            made.with_options({"preset": "standard", "difficulty": 0.0})


def test_an_option_of_the_two_replaces_the_one_that_the_env_was_made_with() -> None:
    graded, named = settings(difficulty=1.0), settings(preset="quick")
    assert named.with_options({"difficulty": 1.0}).configuration({}) == HARD
    assert graded.with_options({"preset": "standard"}).configuration({}) == STANDARD
    assert graded.with_options({"link": "noisy"}).configuration({}) == HARD
    assert named.with_options({"changes": {}}).configuration({}) == PRESETS["quick"]


@pytest.mark.parametrize("entry", [each for each in catalog.entries() if each.env_id], ids=lambda each: each.id)
def test_without_either_the_preset_is_the_env_s_own(entry: catalog.Entry) -> None:
    presets = catalog.scenario(entry.id).presets
    assert FollowSettings(entry.id, "hold").configuration({}) == presets[entry.preset]
    assert gym.spec(entry.env_id).kwargs == {"scenario": entry.id, "tracker": entry.tracker}


def test_drawn_values_take_their_fields_kind() -> None:
    preset = settings(randomise={"traffic_cars": (0, 9), "attitude_noise_deg": (0, 3)}).configuration(
        {"traffic_cars": 4.6, "attitude_noise_deg": 1.25}
    )
    assert preset.traffic_cars == 5
    assert preset.attitude_noise_deg == 1.25


def test_a_curriculum_goes_from_range_to_range_with_the_progress() -> None:
    plain, grows = (settings(randomise={"traffic_cars": limits}) for limits in ((2, 30), [[0, 0], (10, 30)]))
    assert (plain.is_curriculum, grows.is_curriculum) == (False, True)
    assert settings(randomise={"traffic_cars": ((2, 30), (2, 30))}).configuration_of(4) == plain.configuration_of(4)
    assert plain.configuration_of(4) == plain.configuration_of(4, 0.7)
    drawn = {share: [grows.configuration_of(seed, share).traffic_cars for seed in range(300)] for share in (0, 0.5, 1)}
    assert {share: (min(cars), max(cars)) for share, cars in drawn.items()} == {0: (0, 0), 0.5: (5, 15), 1: (10, 30)}
    assert grows.with_options({"progress": 0.5}).configuration_of(3).traffic_cars == drawn[0.5][3]


@pytest.mark.parametrize(
    "limits", [((0, 4), (4,)), ((4, 0), (0, 4)), ((0, 4), (0, 4), (0, 4)), ((0, "a"), (0, 4)), "ab"]
)
def test_what_is_no_curriculum_is_refused(limits: Any) -> None:
    with pytest.raises(ValueError, match=r"randomise.traffic_cars: expected two numbers in ascending order, or two"):
        settings(randomise={"traffic_cars": limits})


@pytest.mark.parametrize("progress", [-0.1, 1.1, "all", float("nan"), True])
def test_progress_is_a_share(progress: Any) -> None:
    with pytest.raises(ValueError, match="progress: expected a number from 0 to 1"):
        settings(progress=progress)


def test_both_ends_of_a_curriculum_are_tried() -> None:
    with pytest.raises(ValueError, match="traffic_cars"):
        settings(randomise={"traffic_cars": ((0, 4), (-9, 4))})
