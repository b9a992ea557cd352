"""What is varied beside the fitted tables: methods' settings on the same pictures, rates in other episodes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.contract.rows import Row, read_rows
from benchmarks.papers import b3, c, d
from benchmarks.papers.claims import Claim
from benchmarks.papers.repeat import repeat
from benchmarks.papers.robustness import FOLDER, Robustness, alias, scaled
from benchmarks.papers.tracker_experiment import TrackerExperiment
from benchmarks.run.selection import tracker_named
from scenarios import catalog
from tests import fakes_scenario
from trackers import registry
from trackers.registry import tunable
from trackers.types import Estimate, Observation

FITTED = (b3.EXPERIMENT, c.EXPERIMENT, d.EXPERIMENT)
FRAMES, FEWER_FRAMES = 30, 20


@dataclass(frozen=True)
class AsideParameters:
    """Where it answers: so far to the right of the first box, and so far below."""

    right_px: float = tunable(20.0, 0.0, 100.0)
    below_px: float = tunable(0.0, 0.0, 100.0)


class Aside:
    """Answers a place beside the first box."""

    Parameters = AsideParameters

    def __init__(self, parameters: AsideParameters, rng: np.random.Generator) -> None:
        self._shift_px = np.array([parameters.right_px, parameters.below_px])

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        self._place_px = 0.5 * (box_xyxy[:2] + box_xyxy[2:]) + self._shift_px

    def update(self, observation: Observation) -> Estimate:
        return Estimate(self._place_px)


EXPERIMENT = TrackerExperiment(
    name="A9",
    title="a place beside the car",
    setting="",
    fitted="how far",
    suite="frame-out",
    scenario=fakes_scenario.FAKE_TOWN.id,
    preset="brief",
    trackers=("aside",),
    claims=(Claim("centre_error_px", "distance", tracker="aside", fitted=True),),
    robustness=Robustness(
        trackers=("aside",),
        metrics=("centre_error_px",),
        settings=scaled("right", (0.5, 2.0), right_px=20.0),
        rates={"fewer frames": {"frame_count": FEWER_FRAMES}},
        words="The place is varied.",
        episodes=2,
    ),
)


@pytest.fixture(autouse=True)
def known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the preset and the method be known, the latter tuned to something else."""
    monkeypatch.setitem(fakes_scenario.FAKE_TOWN.presets, "brief", fakes_scenario.FakeTown("", frame_count=FRAMES))
    monkeypatch.setattr(registry, "_ENTRIES", registry.entries())
    registry.register("aside", role="as-written", summary="beside")(Aside)
    monkeypatch.setattr(registry, "tuned_values", lambda name, module: {"below_px": 77.0} if name == "aside" else {})


def values(rows: list[Row], tracker: str, preset: str, metric: str) -> list[float]:
    found = [row for row in rows if (row["tracker"], row["preset"], row["metric"]) == (tracker, preset, metric)]
    assert [row["seed"] for row in found] == sorted(row["seed"] for row in found)
    return [row["value"] for row in found]


@pytest.mark.heavy
def test_settings_are_varied_on_the_same_pictures_and_rates_in_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    own = fakes_scenario.FAKE_TOWN.episode
    monkeypatch.setattr(
        type(fakes_scenario.FAKE_TOWN),
        "episode",
        lambda self, *given, **named: asked.append(given) or own(*given, **named),
    )
    repeat(EXPERIMENT, tmp_path, range(3), "raster", 0)
    # Three episodes of the experiment, two with both settings, two with fewer frames.
    assert len(asked) == 3 + 2 + 2
    rows = read_rows(tmp_path / FOLDER)
    near, far = (alias("aside", f"right × {factor:g}") for factor in (0.5, 2))
    fewer = alias("brief", "fewer frames")
    assert {(row["tracker"], row["preset"]) for row in rows} == {(near, "brief"), (far, "brief"), ("aside", fewer)}
    assert {row["seed"] for row in rows} == {0, 1}
    frames = {
        preset: values(rows, tracker, preset, "frames") for tracker, preset in ((near, "brief"), ("aside", fewer))
    }
    assert frames == {"brief": [FRAMES] * 2, fewer: [FEWER_FRAMES] * 2}
    editions = {row["tracker"] + row["preset"]: row["editions"] for row in rows}
    assert len({each["tracker"] for each in editions.values()}) == 3
    assert len({each["scene"] for each in editions.values()}) == 2
    printed, page = capsys.readouterr().out, (tmp_path / "paper.html").read_text()
    for words in ("What was fitted, varied", "right × 0.5", "fewer frames"):
        assert words in printed
        assert words in page
    # Nothing is run again.
    repeat(EXPERIMENT, tmp_path, range(3), "raster", 0)
    assert len(asked) == 7


def test_the_table_shows_the_first_episodes_as_set_and_as_varied(tmp_path: Path) -> None:
    repeat(EXPERIMENT, tmp_path, range(3), "raster", 0)
    table = EXPERIMENT.sensitivity(tmp_path, EXPERIMENT.rows_in(tmp_path), range(3), "raster")
    assert table is not None
    assert table.heads == ("varied", "aside: centre error (px)")
    assert [row[0] for row in table.rows] == ["as in the table above", "right × 0.5", "right × 2", "fewer frames"]
    assert "Episodes 0–1" in table.words
    as_set = values(EXPERIMENT.rows_in(tmp_path), "aside", "brief", "centre_error_px")
    assert len(as_set) == 3
    assert table.rows[0][1].startswith(f"{np.mean(as_set[:2]):.1f} (")
    # Half as far is nearer to where the car was, twice as far is farther.
    half, twice = (float(table.rows[k][1].split()[0]) for k in (1, 2))
    assert half < float(table.rows[0][1].split()[0]) < twice
    # The page has the rows of one renderer.
    other = EXPERIMENT.sensitivity(tmp_path, EXPERIMENT.rows_in(tmp_path), range(3), "pybullet")
    assert other is not None
    assert {cell for row in other.rows for cell in row[1:]} == {"–"}


@pytest.mark.parametrize("experiment", FITTED, ids=lambda each: each.name)
def test_what_is_varied_exists_and_changes_what_was_fitted(experiment: TrackerExperiment) -> None:
    made = experiment.robustness
    assert made is not None
    fitted = {(claim.tracker, claim.metric) for claim in experiment.claims if claim.fitted}
    assert {tracker for tracker, _ in fitted} == set(made.trackers)
    assert {metric for _, metric in fitted if "growth" not in metric} <= set(made.metrics)
    own = experiment.runs(range(9), "raster", 0)
    settings, rates = experiment.varied_runs(own)
    for each in (settings, rates):
        assert {episode.seed for episode in each.episodes} == set(range(made.episodes))
    as_written = {tracker_named(name).parameters for name in made.trackers}
    varied = {each.parameters for each in settings.trackers.values()}
    assert len(varied) == len(settings.trackers) / (len(made.trackers) if len(as_written) == 1 else 1)
    assert not varied & as_written
    preset = catalog.scenario(experiment.scenario).presets[experiment.preset]
    presets = list({episode.preset: episode.configuration for episode in rates.episodes}.values())
    assert preset not in presets
    assert len(set(map(repr, presets))) == len(made.rates)


def test_all_values_are_scaled_by_each_factor() -> None:
    assert scaled("size", (0.8, 2.0), wide_px=0.5, high_px=3.0) == {
        "size × 0.8": {"wide_px": 0.4, "high_px": 2.4},
        "size × 2": {"wide_px": 1.0, "high_px": 6.0},
    }
