"""Editions of rows of a scene that lies outside the four packages."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
_EDITIONS_OF_CHANGED_FILES = """
from pathlib import Path
from benchmarks.contract.suite import suite
from benchmarks.run.episodes import editions_of, simulated
from benchmarks.run.own_modules import load_modules
from benchmarks.run.selection import tracker_named

def tell():
    print(editions_of(suite("toy-many"), simulated("toy-yard", "quick", 0), tracker_named("warm_bodies")))

load_modules(["tests.toy_scene.register"])
tell()
for file in ("thermal.py", "judge.py", "tracker.py"):
    path = Path("tests/toy_scene", file)
    held = path.read_text()
    path.write_text(held + "CHANGED = True")
    tell()
    path.write_text(held)
"""


@pytest.mark.heavy
def test_a_change_of_the_scene_is_told_from_one_of_the_tracker(tmp_path: Path) -> None:
    """Rows name the content of a scene, a judge and a tracker that lie outside the four packages."""
    for package in ("sim", "trackers", "scenarios", "benchmarks"):
        (tmp_path / package).symlink_to(ROOT / package)
    toy = tmp_path / "tests" / "toy_scene"
    toy.mkdir(parents=True)
    for file in ("__init__.py", "toy_scene/__init__.py", *(f"toy_scene/{each.name}" for each in _sources())):
        (tmp_path / "tests" / file).write_bytes((ROOT / "tests" / file).read_bytes())

    done = subprocess.run(
        [sys.executable, "-c", _EDITIONS_OF_CHANGED_FILES],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    before, *after = map(ast.literal_eval, done.stdout.splitlines())
    changed = [{name for name in before if before[name] != made[name]} for made in after]
    assert changed == [{"scene"}, {"judge"}, {"tracker"}]


def _sources() -> list[Path]:
    return [each for each in Path(__file__).parent.glob("*.py") if not each.name.startswith("test_")]
