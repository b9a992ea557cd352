"""The suite frame-out on a world of arithmetic."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.contract.suite import Scene
from benchmarks.judges.frame_out.suite import FRAME_OUT
from tests import fakes_scenario


@pytest.fixture
def fake_suite(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let ``frameout bench frame-out`` run on the world of arithmetic."""
    name = fakes_scenario.FAKE_TOWN.id
    fake = replace(FRAME_OUT, scenes=(Scene(name, "frame-out"),), preset="tiny", quick_preset="tiny")
    monkeypatch.setattr("benchmarks.cli.bench.suite", lambda name: fake)
