"""Banks hold the plans of the rendered episodes with the same seeds, and are read back as written."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenarios import catalog
from scenarios.envs.pictureless.bank import episode_bank
from scenarios.road_town.plan import make_plan as road_plan
from scenarios.stereo_follow.plan import make_plan as stereo_plan
from sim.rng import episode_seed

PLANS: dict[str, Any] = {"road-town-v2": road_plan, "stereo-follow-v2": stereo_plan}


@pytest.mark.heavy
@pytest.mark.parametrize("scenario", PLANS)
def test_banks_hold_the_rendered_episodes_plans(scenario: str, tmp_path: Path) -> None:
    preset = catalog.scenario(scenario).presets["quick"]
    made = episode_bank(scenario, preset, [7], tmp_path)
    plan = PLANS[scenario](preset, episode_seed(7, scenario, 0), closed_loop=True)
    truth = plan.motion.position_m[:, 0] if scenario == "road-town-v2" else plan.crowd.walks[0].place_m
    np.testing.assert_array_equal(made.arrays["target_m"][0], truth)
    assert made.frame_count == preset.frame_count == made.arrays["target_m"].shape[1]
    assert made.index_of(7) == 0
    [path] = tmp_path.rglob("*.npz")
    written = path.stat().st_mtime_ns
    again = episode_bank(scenario, preset, [7], tmp_path)
    assert path.stat().st_mtime_ns == written
    for name, values in made.arrays.items():
        assert np.isfinite(values).all(), name
        np.testing.assert_array_equal(values, again.arrays[name])


def test_other_configurations_are_kept_apart(tmp_path: Path) -> None:
    preset = catalog.scenario("stereo-follow-v2").presets["quick"]
    for count in (40, 50):
        made = episode_bank("stereo-follow-v2", dataclasses.replace(preset, frame_count=count), [1], tmp_path)
        assert made.arrays["target_m"].shape == (1, count, 2)
    assert len(list(tmp_path.iterdir())) == 2


def test_episodes_that_measure_nothing_are_refused() -> None:
    for scenario, changes in (("road-town-v2", {"ego": None}), ("stereo-follow-v2", {"odometry": False})):
        preset = dataclasses.replace(catalog.scenario(scenario).presets["quick"], **changes)
        with pytest.raises(ValueError, match=r"preset: expected one with .*, got neither"):
            episode_bank(scenario, preset, [1])
    with pytest.raises(ValueError, match=r"seeds: expected whole numbers >= 0, e\.g\. range\(256\), got \[\]"):
        episode_bank("road-town-v2", catalog.scenario("road-town-v2").presets["quick"], [])
    with pytest.raises(ValueError, match="scenario: expected one of"):
        episode_bank("nowhere-v1", None, [1])
