"""A short run of the world of arithmetic whose estimates were kept, and a data set of the same episodes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.run.editions import preset_edition
from tests import fakes_scenario
from tests.benchmarks.data.estimates.runs import BRIEF, TOWN
from tests.benchmarks.data.sets.small import made, tiny
from tests.benchmarks.named import run_named as run


@pytest.fixture(scope="session", autouse=True)
def brief() -> Iterator[None]:
    """Presets of sixty frames, in which trackers fail on frame 20."""
    presets = fakes_scenario.FAKE_TOWN.presets
    for name, old in BRIEF.items():
        presets[name] = replace(presets[old], frame_count=60)
    yield
    for name in BRIEF:
        del presets[name]


@pytest.fixture(scope="session")
def kept(brief: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Result folder of ``TOWN``, which no test changes."""
    out = tmp_path_factory.mktemp("kept")
    run(TOWN, out)
    return out


@pytest.fixture(scope="session")
def town(brief: None, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Folder of a data set of the episodes of ``TOWN`` on a set path."""
    folder = tmp_path_factory.mktemp("town") / "set"
    scene = preset_edition(fakes_scenario.FAKE_TOWN.id, "brief")
    channels = ("image_rgb", "instance_map", "depth_m", "flow_px")
    asked = tiny(frame_count=None, seeds=(3, 5), channels=channels, scene=scene)
    made(replace(asked, preset="brief"), folder)
    return str(folder)
