"""What a tracker's process does wrong costs its own frames, is named, and touches nobody else."""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import psutil
import pytest

from benchmarks.contract.rows import read_rows
from benchmarks.judges.tracker_speed import times
from benchmarks.run.experiment import run
from benchmarks.run.outcome import Outcome
from benchmarks.run.process_trackers import process_trackers
from benchmarks.run.selection import experiment_on, tracker_named
from tests import fakes_scenario  # noqa: F401

TIMES = {score.metric for score in times([(1.0, 1.0)] * 10, (0.0, 0.0), 10)}
AT_FRAME_20 = {
    "crashes": "ProcessError: it was ended by SIGSEGV, without a word",
    "raises": r"ProcessError: ZeroDivisionError: division by zero \(faulty.py, line \d+\)",
    "answers_half_nan": "ValueError: position_px: expected finite numbers, got .*nan",
    "answers_three_numbers": r"ValueError: position_px: expected the shape \(2,\), got \(3,\)",
    "answers_text": "ValueError: update: expected an Estimate, .* got str",
    "closes_its_pipe": "ProcessError: it ended with exit status 1: OSError: .*Bad file descriptor",
    "exits": "ProcessError: it ended with exit status 0, without a word",
    "exits_with_a_word": "ProcessError: it ended with exit status 1: no weights for this",
    "hangs": "ProcessError: it did not answer within 2 s",
    "eats_memory": "ProcessError: it takes .* GB of memory, more than its limit of 0.4 GB",
}
AT_START = {
    "says_nothing": "ProcessError: it ended with exit status 0, without a word",
    "hangs_at_start": "ProcessError: it did not answer within 10 s",
    "speaks_another_version": "ProcessError: expected version 1 of the protocol, .*, got 99",
}
NO_FAULT = ("prints", "forks", "leaves_a_daemon", "loads_long")
QUICK = ("crashes", "answers_three_numbers", "exits", "says_nothing", "prints", "leaves_a_daemon")
"""Those of the fast layer."""


def run_beside(faults: Sequence[str], folder: Path) -> tuple[Outcome, list[dict[str, Any]]]:
    """Run a healthy tracker in this process, one in its own, and sick ones; return the rows but for their times."""
    shutil.copy(Path(__file__).parents[2] / "trackers" / "clients" / "faulty.py", folder)
    tables = [
        f'[{fault}]\ncommand = "{sys.executable} faulty.py {fault}"\n'
        "start_limit_s = 10\nframe_limit_s = 2\nmemory_limit_gb = 0.4\n"
        for fault in ("healthy", *faults)
    ]
    (folder / "trackers.toml").write_text("\n".join(tables))
    sick = process_trackers([str(folder / "trackers.toml")], 60.0)
    made = experiment_on("frame-out", "fake-town", ["tiny"], {"here": tracker_named("fake_knowing")} | sick, range(1))
    outcome = run(made, folder / "rows")
    rows = [row for row in read_rows(folder / "rows") if row["metric"] not in TIMES]
    return outcome, [row | {"seconds": 0, "process": ""} for row in rows]


def check_faults(faults: Sequence[str], folder: Path) -> None:
    """Check a run with sick trackers beside one without."""
    (folder / "alone").mkdir()
    (folder / "sick").mkdir()
    _, alone = run_beside((), folder / "alone")
    outcome, rows = run_beside(faults, folder / "sick")
    healthy = [row for row in rows if row["tracker"] in ("here", "healthy")]
    assert healthy == alone
    failures = {each.tracker: each for each in outcome.failures}
    expected = set(faults) - set(NO_FAULT)
    assert failures.keys() == expected
    for fault in expected:
        frame, words = (20, AT_FRAME_20[fault]) if fault in AT_FRAME_20 else (0, AT_START[fault])
        assert failures[fault].frame == frame, failures[fault]
        assert re.match(words, failures[fault].reason), failures[fault]
        told = "\n".join(outcome.problems_in_words("a miss"))
        assert f"error: {fault} failed in fake-town-v1 tiny, seed 0, frame {frame}: " in told
        failed = [row["value"] for row in rows if (row["tracker"], row["metric"]) == (fault, "failed_at_frame")]
        assert failed == [frame]
    odd = {name for name, _ in outcome.oddities}
    assert odd == {"leaves_a_daemon"} & set(faults)
    left = [each for each in psutil.process_iter(["cmdline"]) if "faulty.py" in " ".join(each.info["cmdline"] or ())]
    assert not left


def test_some_faults_cost_the_frames_of_their_tracker_alone(tmp_path: Path) -> None:
    check_faults(QUICK, tmp_path)


@pytest.mark.heavy
def test_every_fault_costs_the_frames_of_its_tracker_alone(tmp_path: Path) -> None:
    check_faults([*AT_FRAME_20, *AT_START, *NO_FAULT], tmp_path)
