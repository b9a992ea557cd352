"""A folder that another process writes is refused in one line, and is free once that has ended."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from benchmarks.run.result_folder import alone_in

HOLDS = """
import sys
from pathlib import Path
from benchmarks.run.result_folder import alone_in
with alone_in(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.readline()
"""


def test_a_folder_is_held_until_the_process_ends(tmp_path: Path) -> None:
    words = [sys.executable, "-c", HOLDS, str(tmp_path)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"held\n"
        told = r"^out: expected a folder that no other run writes, got '[^\n]*', which one writes now$"
        with pytest.raises(ValueError, match=told), alone_in(tmp_path):
            pass
        other.kill()
        other.wait()
    with alone_in(tmp_path), ThreadPoolExecutor(1) as pool, pytest.raises(ValueError, match=told):
        pool.submit(lambda: alone_in(tmp_path).__enter__()).result()
    with alone_in(tmp_path):
        pass
    with alone_in(tmp_path):
        pass
