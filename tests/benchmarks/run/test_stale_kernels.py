from __future__ import annotations

import os
from pathlib import Path

import pytest

from benchmarks.run import own_modules as imports
from benchmarks.run.stale_kernels import forget_stale_kernels

NOW_S = 1e9
TEXTS = {
    "sim/shade.py": "",
    "trackers/belief.py": "",
    "trackers/other.py": "",
    "scenarios/room/step.py": "from trackers.belief import look\n",
    "scenarios/walk.py": "from scenarios.room import step\n",
    "scenarios/lamp.py": "from sim.shade import light\n",
    "scenarios/alone.py": "import math\n",
}


def files_with_ages(root: Path, ages_s: dict[str, float]) -> None:
    for name, age_s in ages_s.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(TEXTS.get(name, ""))
        os.utime(path, (NOW_S - age_s, NOW_S - age_s))


def test_kernels_go_when_a_file_that_they_import_is_newer_and_stay_when_another_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``scenarios.walk`` calls a kernel of ``scenarios.room.step``, and this one of ``trackers.belief``."""
    monkeypatch.setattr(imports, "ROOT", tmp_path)
    files_with_ages(tmp_path, dict.fromkeys(TEXTS, 100.0) | {"trackers/belief.py": 10.0})
    indices = {
        "trackers/__pycache__/belief.look-3.py311.nbi": 5.0,
        "trackers/__pycache__/gone.look-3.py311.nbi": 50.0,
        "scenarios/room/__pycache__/step.go-1.py311.nbi": 50.0,
        "scenarios/__pycache__/walk.run-9.py311.nbi": 50.0,
        "scenarios/__pycache__/lamp.shine-9.py311.nbi": 50.0,
        "scenarios/__pycache__/alone.run-9.py311.nbi": 50.0,
    }
    files_with_ages(tmp_path, indices)
    forget_stale_kernels.__wrapped__()
    left = ["alone.run-9.py311.nbi", "belief.look-3.py311.nbi", "lamp.shine-9.py311.nbi"]
    assert sorted(path.name for path in tmp_path.rglob("*.nbi")) == left

    # What stayed is known to be right, until a file changes again.
    with monkeypatch.context() as patched:
        patched.setattr(imports, "imported_files", lambda modules: pytest.fail("asked again"))
        forget_stale_kernels.__wrapped__()
    files_with_ages(tmp_path, {"sim/shade.py": 1.0})
    forget_stale_kernels.__wrapped__()
    assert sorted(path.name for path in tmp_path.rglob("*.nbi")) == left[:2]


def test_kernels_of_the_simulator_are_left_to_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that gets another kernel as an argument does not import its file."""
    monkeypatch.setattr(imports, "ROOT", tmp_path)
    files_with_ages(tmp_path, dict.fromkeys(TEXTS, 100.0) | {"sim/shade.py": 10.0, "sim/__pycache__/row.a-1.nbi": 50.0})
    forget_stale_kernels.__wrapped__()
    assert (tmp_path / "sim/__pycache__/row.a-1.nbi").stat().st_mtime == NOW_S - 50.0
