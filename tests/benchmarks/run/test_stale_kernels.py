from __future__ import annotations

import os
from pathlib import Path

import pytest

from benchmarks.run import source_files
from benchmarks.run.stale_kernels import forget_stale_kernels_below

NOW_S = 1e9


def test_kernels_go_when_a_file_that_they_import_is_newer_and_stay_when_another_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``scenarios.walk`` calls a kernel of ``scenarios.step``, and this one of ``trackers.belief``."""
    monkeypatch.setattr(source_files, "ROOT", tmp_path)
    source_files._read.cache_clear()
    texts = {
        "trackers/belief.py": "",
        "trackers/other.py": "",
        "scenarios/room/step.py": "from trackers.belief import look\n",
        "scenarios/walk.py": "from scenarios.room import step\n",
        "scenarios/alone.py": "import math\n",
    }
    ages_s = dict.fromkeys(texts, 100.0) | {"trackers/belief.py": 10.0}
    indices = {
        "trackers/__pycache__/belief.look-3.py311.nbi": 5.0,
        "scenarios/room/__pycache__/step.go-1.py311.nbi": 50.0,
        "scenarios/__pycache__/walk.run-9.py311.nbi": 50.0,
        "scenarios/__pycache__/alone.run-9.py311.nbi": 50.0,
    }
    for name, age_s in (ages_s | indices).items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(texts.get(name, ""))
        os.utime(path, (NOW_S - age_s, NOW_S - age_s))
    forget_stale_kernels_below(tmp_path, ("trackers", "scenarios"))
    left = sorted(path.name for path in tmp_path.rglob("*.nbi"))
    assert left == ["alone.run-9.py311.nbi", "belief.look-3.py311.nbi"]
    # What stayed is known to be right, until a file changes again.
    monkeypatch.setattr("benchmarks.run.stale_kernels.source_files", lambda modules: pytest.fail("asked again"))
    forget_stale_kernels_below(tmp_path, ("trackers", "scenarios"))
    source_files._read.cache_clear()
