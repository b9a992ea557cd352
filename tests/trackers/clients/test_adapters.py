"""Adapters are short and say what they need, and their documented commands have rows."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.contract.rows import read_rows
from trackers.clients.environments import made_environment, needs
from trackers.clients.remote import PORTABLE

ROOT = Path(__file__).parents[3]
ADAPTERS = [ROOT / "examples" / "roboflow.py", *(PORTABLE / name for name in ("mobilenet_dcf.py", "opencv_contrib.py"))]


def command_of(adapter: Path) -> list[str]:
    """Return the words of the command in an adapter's docstring."""
    found = re.search(r"^    (frameout bench (?:.*\\\n)*.*)$", adapter.read_text(), re.MULTILINE)
    assert found is not None
    return shlex.split(re.sub(r"\\+\n", " ", found[1]))


@pytest.mark.parametrize("adapter", ADAPTERS, ids=lambda path: path.stem)
def test_an_adapter_is_short_and_says_what_it_needs(adapter: Path) -> None:
    assert len(adapter.read_text().splitlines()) < 80
    assert all("==" in package for package in needs(adapter))
    assert needs(adapter)
    assert adapter.name in " ".join(command_of(adapter))


@pytest.mark.heavy
@pytest.mark.parametrize("adapter", ADAPTERS, ids=lambda path: path.stem)
def test_the_command_of_an_adapter_has_rows(adapter: Path, tmp_path: Path) -> None:
    try:
        made_environment(adapter)
    except ValueError as error:
        pytest.skip(str(error))
    kept = [word for word in command_of(adapter)[1:] if not word.startswith("results/") and word != "--out"]
    words = [*kept, "--preset", "quick", "--seeds", "0:1", "--trackers", "sort" if "fish" in kept else "hold"]
    own = set(re.findall(r"roboflow_\w+|\w+(?==\w+\.py)", " ".join(kept)))
    words += sorted(own) if "fish" in kept else []
    program = [sys.executable, "-m", "benchmarks.cli.main"]
    done = subprocess.run([*program, *words, "--out", tmp_path], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = list(read_rows(tmp_path))
    assert own
    assert own <= {row["tracker"] for row in rows}
    assert not [row for row in rows if row["metric"] == "failed_at_frame"]
