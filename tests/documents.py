"""The blocks of README, CONTRIBUTING and the pages of results, and how their commands are run."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
RESULTS = (
    "RESULTS.md",
    *sorted(
        f"docs/results/{each.name}" for each in (ROOT / "docs/results").glob("*.md") if ".template" not in each.name
    ),
)
"""RESULTS.md and what stands behind it."""
MAKE = {"make demo", "make test"}
"""Tested in a fresh clone, see tests/test_setup.py; the second would run itself."""


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, what else stands behind the fence, its text, and the heading above it."""

    language: str
    mark: str
    text: str
    heading: str


def blocks_of(name: str) -> list[Block]:
    found, heading = [], ""
    pattern = re.compile(
        r"^#+ (?P<heading>[^\n]*)$|^```(?P<language>\w+) ?(?P<mark>\w*)\n(?P<text>.*?)^```$", re.M | re.S
    )
    for match in pattern.finditer((ROOT / name).read_text()):
        if match["heading"]:
            heading = match["heading"]
        else:
            found.append(Block(match["language"], match["mark"], match["text"], heading))
    return found


def commands(name: str, mark: str) -> list[str]:
    texts = [block.text for block in blocks_of(name) if block.language == "bash" and block.mark == mark]
    return [line for text in texts for line in text.splitlines() if line not in MAKE]


def in_one_process(command: str) -> str:
    """Return a command so that it needs no workers, each of which imports all again, on cores that run other tests."""
    return (
        f"{command} --workers 0"
        if command.startswith(("frameout bench ", "frameout generate ", "frameout rollout ", "frameout score "))
        else command
    )


def run(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command as a user would who has activated the environment."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path}
    return subprocess.run(command, shell=True, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def succeeds(command: str, folder: Path) -> str:
    done = run(command, folder)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout
