"""Runs of the rendered env: what is written is what was lived; models and checks know what they were made of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.policies.error_models import model_of
from benchmarks.policies.model_check import Compared, as_table, fitted_seeds, model_check, without_pictures
from benchmarks.policies.pictureless_speed import steps_per_s
from benchmarks.policies.runs import Disturbed, read_run, write_runs
from scenarios.envs.settings import FollowSettings
from scenarios.road_town.flight import HELICOPTER
from trackers.controllers.hold import HoldController, HoldParameters
from trackers.types import CameraCommand, CameraModel, Estimate, Observation

SMALL = {"frame_count": 12, "width_px": 96, "height_px": 72}
SETTINGS = FollowSettings("stereo-follow-v1", "hold", preset="quick", changes=SMALL)


def test_runs_are_written_once_and_fitted(tmp_path: Path) -> None:
    [path] = write_runs(SETTINGS, range(3, 4), ["disturbed:hold"], tmp_path)
    run = read_run(path)
    assert len(run) == 12
    assert run["in_view"].dtype == bool
    assert np.isfinite(run["position_px"][0]).all()
    np.testing.assert_allclose(run["estimate_px"][0], run["position_px"][0], atol=8.0)
    assert (run["command"][0] == 0.0).all()
    written = path.stat().st_mtime_ns
    assert write_runs(SETTINGS, range(3, 4), ["disturbed:hold"], tmp_path) == [path]
    assert path.stat().st_mtime_ns == written
    fitted = model_of(SETTINGS, [path])
    assert fitted_seeds(fitted) == {3}
    assert fitted.made["frames"] == 11
    np.save(tmp_path / "other.npy", np.zeros(3))
    with pytest.raises(ValueError, match="path: expected a run"):
        read_run(tmp_path / "other.npy")


def test_disturbances_come_and_go() -> None:
    controller = Disturbed(HELICOPTER, HoldController(HoldParameters()), np.random.default_rng(1))
    estimate, camera = Estimate(np.zeros(2)), CameraModel(8, 8, 10.0)
    picture = np.zeros((8, 8, 3), np.uint8)
    given = [controller.command(Observation(picture, frame / 15.0, camera), estimate) for frame in range(600)]
    calm = np.array([command == CameraCommand() for command in given])
    assert calm[:30].all()
    assert 0.4 < calm.mean() < 0.9
    assert all(abs(command.forward_mps) <= 25.0 for command in given)


def test_checks_are_of_episodes_not_fitted(tmp_path: Path) -> None:
    settings = FollowSettings("road-town-v1", "mosaic_graph_pf")
    with pytest.raises(ValueError, match="seeds: expected episodes that the error model was not fitted to"):
        model_check(settings, ["hold"], [500, 600], tmp_path, lambda done, of: None)


def test_comparisons_are_told_in_per_cent() -> None:
    compared = Compared("centre", (1, 2), np.array([0.5, 0.7]), np.array([0.6, 0.7]))
    heading, row = as_table([compared]).splitlines()
    assert heading.split()[:2] == ["controller", "episodes"]
    assert row.split() == ["centre", "2", "60.0", "%", "65.0", "%", "+5.0", "5.0"]


def test_one_who_stands_loses_the_same_episodes_without_pictures(tmp_path: Path) -> None:
    settings = FollowSettings("stereo-follow-v1", "stereo_people", preset="quick")
    shares = without_pictures(settings, "hold", [3, 4], tmp_path)
    assert shares.shape == (2,)
    assert ((shares > 0.0) & (shares <= 1.0)).all()


def test_speed_is_measured(tmp_path: Path) -> None:
    assert steps_per_s("frameout/StereoFollow-v1", envs=16, seeds=range(2), cache=tmp_path) > 1000
    with pytest.raises(ValueError, match="env_id: expected one of"):
        steps_per_s("frameout/Nothing-v1")
