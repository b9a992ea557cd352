"""Scores on stored episodes are those on rendered ones, in every suite; sets that cannot give them are refused."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from benchmarks.cli.main import main
from benchmarks.contract import suite as registry
from benchmarks.data.sets.benchmark import benchmark_of, stored_specs
from benchmarks.data.sets.generating import Workers, generate
from benchmarks.data.sets.request import Request, existing_channels
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.run.editions import package_versions, preset_edition
from tests.benchmarks.data.sets.small import MODULES, made, tiny
from tests.benchmarks.named import NamedExperiment as Experiment
from tests.benchmarks.named import run_named as run

SUITES = {
    "frame-out": ("road-town-v2", "colour_pf"),
    "stereo": ("stereo-follow-v2", "stereo_wb"),
    "fish": ("fish-tank-v1", "ca_kalman"),
    "harbour": ("harbour-v1", "harbour_mog2"),
}


def rows(out: Path) -> list[dict[str, Any]]:
    """Return the rows of a run but for what was measured with a clock."""
    lines = [json.loads(line) for line in (out / "records.jsonl").read_text().splitlines()]
    clocks = {metric.name for metric in SPEED}
    return [row | {"seconds": None} for row in lines if row["metric"] not in clocks]


@pytest.mark.heavy
@pytest.mark.parametrize("suite", SUITES)
def test_scores_on_stored_episodes_are_those_on_rendered_ones(suite: str, tmp_path: Path) -> None:
    scenario, tracker = SUITES[suite]
    asked = Request(scenario, "quick", (3, 4), ())
    editions = {"scene": preset_edition(scenario, "quick"), "packages": package_versions()}
    request = replace(asked, channels=existing_channels(asked), **editions)
    generate(request, str(tmp_path / "set"), Workers(0), lambda done, whole: None)
    rendered = Experiment(suite, scenario, ("quick",), (tracker,), range(3, 4), workers=0)
    run(rendered, tmp_path / "rendered")
    run(replace(rendered, stored=partial(stored_specs, str(tmp_path / "set"))), tmp_path / "stored")
    assert rows(tmp_path / "stored") == rows(tmp_path / "rendered") != []


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"pictures": "jpeg"}, "data: expected pictures without loss, got jpeg"),
        ({"channels": ("image_rgb",)}, "data: expected a set with all channels, got one without"),
        ({"scene": "other"}, "data: expected one of the scene's present edition"),
    ],
)
def test_a_set_that_gives_other_scores_is_refused(changes: dict[str, Any], message: str, tmp_path: Path) -> None:
    made(tiny(**{"seeds": (3, 4), "preset": "tiny", **changes}), tmp_path / "set")
    with pytest.raises(ValueError, match=message):
        benchmark_of(str(tmp_path / "set"))


@pytest.mark.parametrize("name", ["pixels-00000.tar", "objects.parquet"])
def test_a_file_that_is_gone_is_told_in_one_line(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    judged = registry.suite("frame-out")
    scenes = (*judged.scenes, registry.Scene("fake-town"))
    monkeypatch.setitem(registry._SUITES, "frame-out", replace(judged, scenes=scenes))
    folder, own = tmp_path / "set", ["--workers", "0", "--modules", *MODULES]
    assert main(["generate", "fake-town", "--preset", "tiny", "--seeds", "0:1", "--out", str(folder), *own]) == 0
    (folder / "episodes" / "000000" / name).unlink()
    capsys.readouterr()
    bench = ["bench", "frame-out", "--data", str(folder), "--trackers", "hold", "--out", str(tmp_path / "out"), *own]
    assert main(bench) == 2
    told = capsys.readouterr().err.splitlines()[-1]
    assert re.match(rf"error: .*{name}: expected a whole (shard|table) \(see frameout verify\), got ", told)
