"""Recorded runs equal the rendered env; models and checks store their seeds."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.learning.tracker_errors import Disturbed, model_of, read_run, run_of, write_runs
from benchmarks.learning.without_pictures import as_table, fitted_seeds, model_check, scores_without_pictures
from scenarios.envs.settings import FollowSettings
from scenarios.road_town.flight import HELICOPTER
from tools.speed.envs import measure_pictureless
from trackers.controllers.hold import HoldController
from trackers.registry import NoParameters
from trackers.types import CameraCommand, CameraModel, Estimate, Observation

SMALL = {"frame_count": 12, "width_px": 96, "height_px": 72}
SETTINGS = FollowSettings("stereo-follow-v2", "hold", preset="quick", changes=SMALL)


@pytest.mark.heavy
def test_runs_are_written_once_and_fitted(tmp_path: Path) -> None:
    [path] = write_runs(SETTINGS, range(3, 4), ["disturbed:hold"], tmp_path)
    run = read_run(path)
    assert len(run) == 12
    assert run["in_view"].dtype == bool
    assert np.isfinite(run["estimate_px"][0]).all()
    written = path.stat().st_mtime_ns
    assert write_runs(SETTINGS, range(3, 4), ["disturbed:hold"], tmp_path) == [path]
    assert path.stat().st_mtime_ns == written
    others = dataclasses.replace(SETTINGS, changes=SMALL | {"frame_count": 13})
    assert write_runs(others, range(3, 4), ["disturbed:hold"], tmp_path) != [path]
    fitted = model_of(SETTINGS, [path])
    assert fitted_seeds(fitted) == {3}
    assert fitted.made["frames"] == 11
    np.save(tmp_path / "other.npy", np.zeros(3))
    with pytest.raises(ValueError, match="path: expected a run"):
        read_run(tmp_path / "other.npy")


def test_disturbances_come_and_go() -> None:
    controller = Disturbed(HELICOPTER, HoldController(NoParameters()), np.random.default_rng(1))
    estimate, camera = Estimate(np.zeros(2)), CameraModel(8, 8, 10.0)
    picture = np.zeros((8, 8, 3), np.uint8)
    given = [controller.command(Observation(picture, frame / 15.0, camera), estimate) for frame in range(600)]
    calm = np.array([command == CameraCommand() for command in given])
    assert calm[:30].all()
    assert 0.4 < calm.mean() < 0.9
    assert all(abs(command.forward_mps) <= 25.0 for command in given)


def test_checks_are_of_episodes_not_fitted(tmp_path: Path) -> None:
    settings = FollowSettings("road-town-v2", "mosaic_graph_pf")
    with pytest.raises(ValueError, match="seeds: expected episodes that the error model was not fitted to"):
        model_check(settings, ["hold"], [500, 600], tmp_path, lambda done, of: None)


def test_comparisons_are_in_per_cent() -> None:
    columns = ["controller", "seed", "with pictures", "without"]
    compared = pd.DataFrame([("centre", 1, 0.5, 0.6), ("centre", 2, 0.7, 0.7), ("hold", 1, 0.5, 0.25)], columns=columns)
    heading, *rows = as_table(compared).splitlines()
    assert heading.split()[:2] == ["controller", "episodes"]
    assert [row.split() for row in rows] == [
        ["centre", "2", "60.0", "65.0", "5.0", "5.0"],
        ["hold", "1", "50.0", "25.0", "-25.0", "25.0"],
    ]


@pytest.mark.heavy
def test_a_hovering_carrier_sees_the_same_with_pictures_and_without(tmp_path: Path) -> None:
    """A hovering carrier ignores the tracker's errors: only plan and dynamics are compared."""
    scores = scores_without_pictures("road-town-v2", "quick", "mosaic_graph_pf", "hold", {}, [3], tmp_path)
    rendered = run_of(FollowSettings("road-town-v2", "hold", preset="quick"), 3, "hold")
    assert scores["time_in_view"] == pytest.approx([rendered["in_view"][1:].mean()], abs=1e-12)
    assert 0.0 < scores["time_in_view"][0] < 1.0
    assert scores["effort"] == pytest.approx([0.0])


def test_repeats_are_averaged_for_each_episode(tmp_path: Path) -> None:
    """A hovering carrier has the same scores in every repeat."""
    once, often = (
        scores_without_pictures("road-town-v2", "quick", "mosaic_graph_pf", "hold", {}, [3, 4, 5], tmp_path, repeats)
        for repeats in (1, 5)
    )
    assert len(set(once["time_in_view"])) > 1
    np.testing.assert_allclose(often["time_in_view"], once["time_in_view"], atol=1e-12)


@pytest.mark.heavy
def test_speed_without_pictures_is_measured(tmp_path: Path) -> None:
    (measured,) = measure_pictureless("frameout/StereoFollow-v3", "quick", tmp_path, 0).items()
    assert measured[0] == "env_steps_per_s_without_pictures"
    assert 0 < measured[1].below < 1
