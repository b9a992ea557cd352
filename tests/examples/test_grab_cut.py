"""The example that answers with masks: they lie on the car."""

from __future__ import annotations

import numpy as np
from grab_cut import GrabCut

from benchmarks.judges.masks import MaskScores
from scenarios import catalog
from trackers.estimate_check import check_estimate


def test_its_masks_overlap_the_car() -> None:
    scenario = catalog.scenario("road-town")
    episode = scenario.episode("quick", 0)
    tracker, kept = GrabCut(GrabCut.Parameters(), np.random.default_rng(0)), MaskScores()
    tracker.initialise(episode.step().observation, episode.start.box_xyxy)
    for _ in range(20):
        frame = episode.step()
        answer = check_estimate(tracker.update(frame.observation), frame.observation.camera)
        kept.keep(frame.truth, frame.truth.index_of(scenario.target), answer)
    episode.close()
    values = {score.metric: score.value for score in kept.scores()}
    assert values["mask_iou"] > 0.4
    assert values["contour_accuracy"] > 0.6
