"""What a contestant sets in the process holds on its own turns; what it starts ends with it."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from benchmarks.run.process_state import ProcessState

IN_FILES = pytest.mark.skipif(not Path("/proc/self/stat").is_file(), reason="no file tells the processes")
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
    assert mine.close() == ["left 1 process running, now ended"]
    assert left.wait(10) != 0
    assert earlier.poll() is None
    earlier.kill()
    earlier.wait()


def test_a_thread_that_is_left_is_told() -> None:
    state, end = ProcessState(), threading.Event()
    thread = threading.Thread(target=end.wait)
    with state.applied():
        thread.start()
    assert state.close() == ["left 1 thread running"]
    end.set()
    thread.join()
    assert state.close() == []


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
