"""The runs whose estimates tests keep, and rows without what depends on the clock."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.contract.rows import read_rows
from benchmarks.data.estimates.keeping import Estimates
from benchmarks.data.estimates.rejudging import Rejudged, rejudge
from tests import fakes_scenario
from tests.benchmarks.named import NamedExperiment as Experiment

BRIEF = {"brief": "tiny", "brief-loop": "tiny-loop"}
TOWN = Experiment(
    suite="frame-out",
    scenario=fakes_scenario.FAKE_TOWN.id,
    presets=("brief",),
    trackers=("fake_knowing", "fake_still", "fake_raises", "fake_silent", "fake_half_nan"),
    seeds=range(3, 5),
    workers=0,
    modules=(fakes_scenario.__name__,),
    keeper=Estimates(),
)


def rows_in(directory: Path) -> list[dict[str, Any]]:
    """Return all rows without ``seconds``, which nobody measures when estimates are judged again."""
    return [{name: value for name, value in row.items() if name != "seconds"} for row in read_rows(directory)]


def judged_again(directory: Path, data: str | None = None) -> Rejudged:
    """Judge the estimates of a folder again, in this process."""
    return rejudge(directory, data, 0, (), lambda done, of: None)
