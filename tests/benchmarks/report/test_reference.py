"""The page of definitions equals the code's, and is complete."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.report.reference import definitions_of, metrics_of, reference_page
from benchmarks.suites.registry import suite
from scenarios.envs.reward import TERMS, Reward
from trackers.belief.features import COMMANDS, FEATURES, features_of
from trackers.belief.kernel import BELIEF

ROOT = Path(__file__).parents[3]
SUITES = ("fish", "follow", "frame-out", "harbour", "stereo")


def test_the_committed_page_is_what_the_command_prints() -> None:
    """In a process of its own: other tests register suites and metrics here."""
    command = [sys.executable, "-m", "benchmarks.cli", "list", "--reference"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    expected = (ROOT / "REFERENCE.md").read_text()
    assert done.stdout == expected, "make it anew: frameout list --reference > REFERENCE.md"


@pytest.mark.parametrize("name", SUITES)
def test_every_row_of_every_metric_is_defined(name: str) -> None:
    """A definition is a docstring of more than a few words, and defines nothing that no metric is made of."""
    scores = suite(name)
    needed = {row for metric in metrics_of(scores) for row in metric.rows}
    definitions = definitions_of(scores)
    assert {row for rows in definitions.values() for row in rows} == needed
    for thing in definitions:
        assert len((thing.__doc__ or "").split()) >= 5, thing


def test_the_page_names_what_an_env_tells() -> None:
    page = reference_page()
    for name in (*FEATURES, *TERMS, *Reward.__dataclass_fields__, "T_world_camera", "reward_loss"):
        assert f"`{name}`" in page or f"\n    {name}:" in page, name


def test_there_are_as_many_meanings_as_features() -> None:
    """The vector is filled by index: a row of ones at the end shows that it is as long as its list of names."""
    out = np.full((1, len(FEATURES)), np.nan, np.float32)
    features_of(np.zeros(1, BELIEF), np.ones((1, COMMANDS)), out)
    assert np.isfinite(out).all()
    assert (out[0, -COMMANDS:] == 1.0).all()
    assert FEATURES[-COMMANDS:] == ("command_forward", "command_right", "command_climb", "command_yaw_rate")
