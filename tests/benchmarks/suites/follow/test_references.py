"""The oracle of suite follow answers the truth, and a pair with it is an oracle whatever its controller."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from benchmarks.run.jobs import Job, heading_of
from benchmarks.suites.follow.references import ORACLE
from scenarios import catalog
from scenarios.loop import Loop
from sim.optics import PinholeCamera
from trackers.types import Estimate


def test_it_answers_the_true_position_and_distance_also_outside_the_picture() -> None:
    scenario = catalog.scenario("road-town")
    with closing(scenario.episode("quick", 3)) as episode:
        loop = Loop(episode, [ORACLE.create(episode, scenario, np.random.default_rng(0))])
        for frame in loop.frames():
            truth, answer = frame.truth, loop.answers[0]
            target = truth.index_of("target")
            assert isinstance(answer, Estimate)
            if truth.frame > 0:
                assert answer.position_px == pytest.approx(truth.position_px[target])
                assert answer.in_view_probability == (truth.state[target] in ("in", "partial"))
                camera: PinholeCamera = frame.camera
                ray = np.append((answer.position_px - camera.centre_px) / camera.focal_px, 1.0)
                middle_m = (truth.T_world_camera @ np.append(ray * answer.depth_m, 1.0))[:3]
                assert middle_m[:2] == pytest.approx(truth.T_world_object[target, :2, 3], abs=1e-6)
            if truth.state[target] == "out":
                break
        else:
            pytest.fail("the car never left the picture")


@pytest.mark.parametrize(("tracker_role", "role"), [("oracle", "oracle"), ("blind", "blind"), ("ours", "baseline")])
def test_a_pair_with_unfair_knowledge_is_not_ranked(tracker_role: str, role: str) -> None:
    job = Job("follow", "road-town", "quick", "raster", 0, "centre", ("oracle_target",))
    assert heading_of(job, "oracle_target", tracker_role)["role"] == role
