"""Seeds and names of commands, as users write them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from benchmarks.cli.arguments import _names, development_seeds
from benchmarks.cli.main import main
from benchmarks.contract.text import seed_range


@pytest.mark.parametrize(("text", "seeds"), [("3", range(3, 4)), ("0", range(1)), ("2:5", range(2, 5))])
def test_seeds_are_a_range_or_one(text: str, seeds: range) -> None:
    assert seed_range(text) == development_seeds(text) == seeds


def test_one_seed_of_the_test_split_is_not_for_development() -> None:
    with pytest.raises(ValueError, match="expected development seeds, below 10000, got '10000'"):
        development_seeds("10000")


@pytest.mark.parametrize("preset", ["quick[traffic_cars=3,weather=rain]", "quick[traffic_cars=3,vehicles=[sedan,van]]"])
def test_a_preset_with_several_values_is_one_name(
    preset: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """It was cut at the comma. Of the names the last one is wrong."""
    words = ["--preset", f"hard,{preset},{preset},nix", "--trackers", "hold", "--out", str(tmp_path / "out")]
    assert main(["bench", "frame-out", *words]) == 2
    assert re.match(r"error: preset: expected one of .*; got 'nix'", capsys.readouterr().err)
    assert _names([f"hard,{preset}", preset]) == ("hard", preset)


@pytest.mark.parametrize("name", ["a2", "A2"])
def test_a_paper_is_found_in_small_letters_and_its_rows_in_one_place(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[Any] = []
    monkeypatch.setattr("benchmarks.cli.paper.repeat", lambda *given: calls.append(given))
    assert main(["paper", name, "--seeds", "3", "--workers", "0"]) == 0
    ((experiment, out, seeds, renderer, workers),) = calls
    assert (experiment.name, str(out), seeds, renderer, workers) == ("A2", "results/paper-a2", range(3, 4), "raster", 0)
