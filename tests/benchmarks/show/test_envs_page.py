"""The page about the envs can be made, leaves nothing out, is right about ``changes``, and its examples run."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest

from benchmarks.cli.main import main
from benchmarks.show.reference import envs_page, fields_of_preset
from scenarios import catalog
from scenarios.command_link import LINKS
from scenarios.envs.reward import Reward
from scenarios.envs.settings import RESET_OPTIONS, FollowSettings
from scenarios.envs.truth_info import INFO
from tools.speed import envs as speed_of_envs
from trackers.belief.features import FEATURES
from trackers.controllers.catalogue import controllers

PAGE = envs_page()
EXAMPLES = re.findall(r"^```python\n(.*?)^```$", PAGE, re.M | re.S)
ENTRIES = [each for each in catalog.entries() if each.env_id and each.place.startswith("scenarios.")]


def test_the_command_prints_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--envs"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("# Envs\n")
    # Other tests register scenes after this module was read.
    assert set(re.findall(r"^## (.+)$", printed, re.M)) == set(re.findall(r"^## (.+)$", PAGE, re.M)) != set()


def test_the_page_leaves_nothing_out() -> None:
    named = {*FEATURES, *Reward.__dataclass_fields__, *INFO, *LINKS, *RESET_OPTIONS, "render_mode"}
    named |= {*FollowSettings.__dataclass_fields__} - {"scenario"}
    for entry in ENTRIES:
        carrier = catalog.scenario(entry.id).carrier
        named |= {entry.env_id, entry.tracker, entry.preset, *(axis.name for axis in carrier.axes)}
        named |= {field for each in controllers(carrier.name).values() for field in each.tunables()}
    assert {name for name in named if f"`{name}`" not in PAGE} == set()


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda each: each.id)
def test_changes_and_randomise_take_what_the_page_says(entry: catalog.Entry) -> None:
    """Each field with the preset's own value, and as a range of no width."""
    preset = catalog.scenario(entry.id).presets[entry.preset]
    told = fields_of_preset(preset)
    left_out = {"summary", "closed_loop"} & preset.__dataclass_fields__.keys()
    assert len(told) == len(preset.__dataclass_fields__) - len(left_out)
    for field in told:
        value = getattr(preset, field.name)
        assert field.meaning, field.name
        assert f"| `{field.name}` | `" in PAGE
        assert FollowSettings(entry.id, "hold", changes={field.name: value}).configuration({}) == preset
        try:
            FollowSettings(entry.id, "hold", randomise={field.name: (value, value)})
        except ValueError:
            taken = False
        else:
            taken = True
        assert taken == field.drawn, field.name


@pytest.mark.heavy
@pytest.mark.parametrize("text", EXAMPLES, ids=["changes", "curriculum", "pixels", "video"])
def test_the_examples_run(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if "RecordVideo" in text:
        pytest.importorskip("moviepy")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    # A video of a few steps is written as one of more.
    exec(text.replace("range(30)", "range(3)"), names)
    if "tracker=None" in text:
        assert capsys.readouterr().out == "(84, 84, 3) (4,)\n"
    if "RecordVideo" in text:
        assert len(list((tmp_path / "results" / "videos").glob("*.mp4"))) == 1


def test_what_the_page_says_of_costs_is_measured() -> None:
    costs = PAGE.partition("## Costs")[2]
    assert f"`{catalog.DEFAULT_ENV}`" in costs
    assert f"tools speed {catalog.unversioned(speed_of_envs.SCENARIO)}`" in costs
    for name in re.findall(r"`(env_\w+)`", costs):
        assert f'"{name}"' in inspect.getsource(speed_of_envs)
