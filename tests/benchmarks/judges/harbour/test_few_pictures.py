"""Trackers that learn from few pictures: they get those, evenly over time, and are otherwise themselves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from benchmarks.judges.harbour.few_pictures import COUNTS, TAUGHT_BY_FEW, FewPictures
from benchmarks.show.suites.harbour import by_pictures, charts
from benchmarks.statistics import froc
from scenarios.loop import ManyFromPictures
from tests.benchmarks.judges.harbour.hand_made import frame_of, truth_of
from trackers import registry
from trackers.types import CameraModel, Observation, Track


class Counts:
    """Keeps the times of its pictures."""

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        self.times_s = [each.time_s for each in background]

    def update(self, observation: Observation) -> list[Track]:
        return []


@pytest.mark.parametrize(
    ("count", "expected"), [(3, [0.0, 10.0, 20.0]), (11, list(range(0, 21, 2))), (99, range(0, 21, 2))]
)
def test_pictures_are_taken_evenly(count: int, expected: Sequence[float]) -> None:
    frame = frame_of(truth_of([], 0))
    pictures = [frame_of(truth_of([], k)).observation for k in range(11)]
    tracker = Counts()
    FewPictures(tracker, count).start(pictures, frame.observation.camera)
    assert tracker.times_s == list(expected)
    FewPictures(tracker, count).start([], frame.observation.camera)
    assert tracker.times_s == []


def test_it_decides_as_the_tracker_does() -> None:
    class Decides(Counts):
        decides_at = 0.4

    assert ManyFromPictures(FewPictures(Decides(), 3)).decides_at() == 0.4
    assert ManyFromPictures(FewPictures(Counts(), 3)).decides_at() == 0.0


def test_parameters_are_the_tracker_s() -> None:
    for (of, count), spec in TAUGHT_BY_FEW.items():
        assert spec.parameters == registry.entry(of).parameters()
        assert (spec.name, count in COUNTS) == (f"{of}_{count}_pictures", True)
        assert spec.suites == registry.entry(of).suites


def rows(found: int, seed: int) -> list[dict[str, Any]]:
    """Return the rows of an episode in which so many of ten are found, without alarms."""
    some = froc.reached(np.r_[np.ones(found), np.full(10 - found, -np.inf)]).tolist()
    every = [10.0] * len(froc.THRESHOLDS)
    values = {"froc_found": some, "froc_findable": every, "froc_alarms": [0.0] * len(every), "watched_hours": 1.0}
    shared = {"suite": "harbour", "scenario": "harbour-v1", "preset": "standard", "seed": seed, "event": None}
    return [{**shared, "metric": name, "value": value, "weight": 1.0} for name, value in values.items()]


def test_the_figure_has_a_point_for_each_number() -> None:
    drawn = {"eigen_swarm": rows(8, 0), "eigen_swarm_25_pictures": rows(2, 0), "harbour_watch": rows(9, 0)}
    curve = by_pictures(drawn, "eigen_swarm")
    assert curve is not None
    assert (curve.x.tolist(), curve.mean.tolist()) == ([25.0, 400.0], [0.2, 0.8])
    assert by_pictures(drawn, "harbour_watch") is None
    assert by_pictures(drawn, "eigen_swarm_25_pictures") is None
    titles = [chart.title for chart in charts(drawn) if chart.values]
    assert titles == ["How many false alarms does a find cost?", "How many pictures does it take?"]
