"""What a tracker sets in the process holds on its own turns; what it starts ends with it."""

from __future__ import annotations

import contextlib
import gc
import multiprocessing
import os
import signal
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import joblib
import numpy as np
import pytest
from joblib.externals.loky import get_reusable_executor

from benchmarks.run.process_state import ProcessState

IN_FILES = pytest.mark.skipif(not Path("/proc/thread-self/children").is_file(), reason="no file tells the processes")
ASLEEP = [sys.executable, "-c", "import time; time.sleep(600)"]


def test_a_setting_is_that_of_who_set_it(tmp_path: Path) -> None:
    mine, yours = ProcessState(), ProcessState()
    before = np.geterr(), os.getcwd()
    with mine.applied():
        np.seterr(all="raise")
        os.chdir(tmp_path)
        drawn = np.random.RandomState(3).rand(2)
        np.random.seed(3)  # noqa: NPY002
        assert np.random.rand() == drawn[0]  # noqa: NPY002
    for _ in range(2):
        assert (np.geterr(), os.getcwd()) == before
        with yours.applied():
            assert (np.geterr(), os.getcwd()) == before
            np.random.rand(5)  # noqa: NPY002
    with mine.applied():
        assert set(np.geterr().values()) == {"raise"}
        assert os.getcwd() == str(tmp_path)
        assert np.random.rand() == drawn[1]  # noqa: NPY002
        os.chdir(before[1])
    with mine.applied():
        assert os.getcwd() == before[1]


@pytest.mark.parametrize(
    ("change", "read"),
    [
        (lambda: os.environ.update(MINE="1"), lambda: os.environ.get("MINE")),
        (lambda: os.environ.pop("PATH"), lambda: "PATH" in os.environ),
        (lambda: sys.path.append("mine"), lambda: "mine" in sys.path),
        (lambda: setattr(sys, "path", ["mine"]), lambda: "mine" in sys.path),
        (lambda: warnings.simplefilter("ignore", ResourceWarning), lambda: list(warnings.filters)),
        (gc.disable, gc.isenabled),
        (lambda: cv2.setUseOptimized(False), cv2.useOptimized),
    ],
)
def test_each_setting_holds_on_the_turns_of_who_set_it(change: Callable[[], Any], read: Callable[[], Any]) -> None:
    mine, before = ProcessState(), read()
    # A command ignores some warnings meanwhile, with a list of filters of its own.
    with warnings.catch_warnings():
        with mine.applied():
            change()
            changed = read()
        for _ in range(2):
            assert read() == before != changed
            with ProcessState().applied():
                assert read() == before
            with mine.applied():
                assert read() == changed


def test_a_setting_is_put_back_after_an_exception_and_in_a_folder_that_is_gone(tmp_path: Path) -> None:
    state, before = ProcessState(), os.getcwd()
    with contextlib.suppress(RuntimeError), state.applied():
        (tmp_path / "gone").mkdir()
        os.chdir(tmp_path / "gone")
        (tmp_path / "gone").rmdir()
        raise RuntimeError
    assert os.getcwd() == before
    with state.applied():
        pass
    assert os.getcwd() == before


@IN_FILES
def test_a_process_that_is_left_is_ended_and_told_by_whose_it_is() -> None:
    mine, yours = ProcessState(), ProcessState()
    earlier = subprocess.Popen(ASLEEP)
    with mine.applied():
        left = subprocess.Popen(ASLEEP)
    with yours.applied():
        ended = subprocess.Popen(ASLEEP)
        ended.kill()
        ended.wait()
    assert yours.close() == []
    assert mine.close() == ["left 1 process running, ended with the episode (start anew in each)"]
    assert left.wait(10) != 0
    assert earlier.poll() is None
    earlier.kill()
    earlier.wait()


@IN_FILES
def test_a_process_of_another_parent_is_not_ended() -> None:
    """It may have the number of a child that ended long ago."""
    starts = f"import subprocess; print(subprocess.Popen({ASLEEP!r}).pid, flush=True); input()"
    words = [sys.executable, "-c", starts]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as stranger:
        assert stranger.stdout is not None
        number = int(stranger.stdout.readline())
        state = ProcessState()
        state._children.add(number)
        assert state.close() == []
        os.kill(number, signal.SIGKILL)
        stranger.communicate(b"\n")


@pytest.mark.heavy
@IN_FILES
def test_the_pool_of_joblib_is_ended_and_is_there_again_for_the_next_one() -> None:
    # Of other tests, whose pool is not the tracker's.
    get_reusable_executor().shutdown(wait=True)
    for _ in range(2):
        state = ProcessState()
        with state.applied():
            assert joblib.Parallel(2, backend="loky")(joblib.delayed(abs)(k) for k in (-1, -2, -3)) == [1, 2, 3]
        assert state.close()[0] == "left 2 processes running, ended with the episode (start anew in each)"


@pytest.mark.heavy
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_forked_child_does_not_come_back_from_its_turn() -> None:
    child = multiprocessing.get_context("spawn").Process(target=fork_and_go_on)
    child.start()
    child.join()
    assert child.exitcode == 0


def fork_and_go_on() -> None:
    """Exit by 0 in the parent alone, and if the child has ended by 1."""
    child = 0
    with ProcessState().applied():
        child = os.fork()
    if child == 0 or os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != 1:
        os._exit(2)
