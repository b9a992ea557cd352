"""What trackers print never mixes with results."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from joblib.externals.loky import get_reusable_executor

from benchmarks.cli.main import main
from benchmarks.cli.printing import trackers_print_to_stderr


def test_this_process_and_those_it_starts_print_to_stderr(capfd: pytest.CaptureFixture[str]) -> None:
    with trackers_print_to_stderr():
        print("mine", flush=True)
        subprocess.run([sys.executable, "-c", "print('its')"], check=True)
    print("result", flush=True)
    out, err = capfd.readouterr()
    assert out == "result\n"
    assert err == "mine\nits\n"


def test_what_waits_in_a_buffer_goes_to_stderr_too() -> None:
    script = """
import ctypes, sys
from benchmarks.cli.printing import trackers_print_to_stderr
stdout = sys.stdout
with trackers_print_to_stderr():
    stdout.write("kept\\n")
    ctypes.CDLL(None).puts(b"native")
print("result")
"""
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    done = subprocess.run([sys.executable, "-c", script], env=buffered, capture_output=True, text=True, check=True)
    assert done.stdout == "result\n"
    assert sorted(done.stderr.split()) == ["kept", "native"]


@pytest.mark.heavy
@pytest.mark.usefixtures("fake_suite")
@pytest.mark.parametrize("workers", ["0", "1"])
def test_a_tracker_that_prints_leaves_results_as_they_are(
    workers: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    # Worker processes that an earlier test has left print where that test printed.
    get_reusable_executor().shutdown(wait=True)
    words = ["bench", "--workers", workers, "--seeds", "0:1", "--trackers", "fake_prints", "--out", str(tmp_path)]
    words += ["--modules", "tests.fakes_scenario"]
    assert main([*words, "--json"]) == 0
    out, err = capfd.readouterr()
    assert json.loads(out)["failures"] == []
    assert "frame 20\n" in err
