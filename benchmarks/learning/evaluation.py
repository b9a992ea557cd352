"""Evaluates policies with pictures while they are trained: by the command that users run, in a process beside."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from collections import deque
from dataclasses import dataclass
from pathlib import Path

from benchmarks.contract.suite import controllers_suite
from benchmarks.learning.settings import Training
from benchmarks.statistics.summary import COMPARISONS_FILE_NAME, SUMMARY_FILE_NAME
from trackers.controllers.catalogue import POLICY

JUDGED = range(9_992, 10_000)
"""Development episodes. A training without pictures plans the first ones; one with pictures draws from all 10,000, so
that it may meet these, each once in 10,000 episodes.
"""
_FOLDER, _LOG = "judged", "judged.log"


def judging_command(training: Training, policy: Path) -> str:
    """Return the command, quoted for a shell, that judges a policy with pictures beside the controller it corrects.

    One that steers alone is compared with ``centre``.
    """
    return shlex.join(["frameout", *_words(training, policy, policy.parent / _FOLDER)])


def _words(training: Training, policy: Path, out: Path) -> list[str]:
    words = ["bench", controllers_suite().name, "--scenario", training.scenario]
    words += ["--preset", training.preset_name, "--trackers", training.tracker_name]
    words += ["--controllers", f"{POLICY}{policy}", _beside(training)]
    words += ["--seeds", f"{JUDGED.start}:{JUDGED.stop}", "--out", str(out)]
    if isinstance(link := training.env_kwargs.get("link"), str):
        words += ["--link", link]
    return [*words, *(("--modules", *training.modules) if training.modules else ())]


def _beside(training: Training) -> str:
    return "centre" if training.controller_name == "none" else training.controller_name


@dataclass(frozen=True)
class Evaluation:
    """How a policy does with pictures, over the episodes ``JUDGED``.

    Attributes:
        steps: of its training.
        time_seen: share of the frames with the target seen, see suite ``follow``.
        controller: name of the controller beside it.
        difference: policy minus controller of the share, paired. ci_low, ci_high: its 95 % interval.
    """

    steps: int
    time_seen: float
    controller: str
    difference: float
    ci_low: float
    ci_high: float


class Evaluations:
    """Evaluates policies one after the other, while their training goes on, which they do not change.

    Rows are in ``OUT/judged``, what the command prints in ``OUT/judged.log``.
    """

    def __init__(self, training: Training, out: Path) -> None:
        self._training, self._out = training, out
        self._waiting: deque[tuple[int, Path]] = deque()
        self._process: subprocess.Popen[bytes] | None = None

    def begin(self, policy: Path, steps: int) -> None:
        """Evaluate a policy file after the earlier ones."""
        self._waiting.append((steps, policy))
        self._start_next()

    def ended(self, wait: bool = False) -> list[Evaluation]:
        """Return what has ended since the last call; ``wait``: all.

        Raises:
            ChildProcessError: if the command fails.
        """
        found = []
        while self._process is not None and (wait or self._process.poll() is not None):
            if self._process.wait() != 0:
                said = (self._out / _LOG).read_text().strip().rpartition("\n")[2]
                raise ChildProcessError(f"evaluation: it ended with status {self._process.returncode}: {said}")
            found.append(self._read(*self._waiting.popleft()))
            self._process = None
            self._start_next()
        return found

    def stop(self) -> None:
        """End the command that runs, and forget those that wait. The same training evaluates its last policy anew."""
        self._waiting.clear()
        if self._process is not None:
            self._process.terminate()
            self._process.wait()
            self._process = None

    def _start_next(self) -> None:
        if self._process is not None or not self._waiting:
            return
        words = _words(self._training, self._waiting[0][1], self._out / _FOLDER)
        command = [sys.executable, "-m", "benchmarks.cli.main", *words, "--workers", "1"]
        with (self._out / _LOG).open("wb") as log:
            # In a session of its own: Ctrl-C is for the training, which ends it.
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True
            )

    def _read(self, steps: int, policy: Path) -> Evaluation:
        name, beside, folder = f"{POLICY}{policy}", _beside(self._training), self._out / _FOLDER
        own, compared = (
            [row for row in json.loads((folder / file).read_text()) if row["metric"] == "time_seen"]
            for file in (SUMMARY_FILE_NAME, COMPARISONS_FILE_NAME)
        )
        [mean] = [row["mean"] for row in own if row["controller"] == name]
        [pair] = [row for row in compared if (row["controller"], row["other"]) == (name, beside)]
        return Evaluation(steps, mean, beside, pair["difference"], pair["ci_low"], pair["ci_high"])
