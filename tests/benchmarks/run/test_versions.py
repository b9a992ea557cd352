from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.run.contestants import entrant
from benchmarks.run.versions import _imported, _modules_hash, versions_of
from trackers.controllers.catalogue import controller_entry


def test_a_change_of_parameters_shows_and_only_there() -> None:
    known = entrant("colour_pf")
    changed = replace(known, parameters="others")
    first, second = versions_of(known), versions_of(changed)
    assert first.pop("tracker") != second.pop("tracker")
    assert first == second
    assert set(first) == {"frameout", "numpy", "numba", "opencv", "pybullet", "scene"}


def test_who_steers_shows_beside_what_tracks(monkeypatch: pytest.MonkeyPatch) -> None:
    known, centre = entrant("colour_pf"), controller_entry("centre", "helicopter")
    alone, steered = versions_of(known), versions_of(known, centre)
    assert {name: steered[name] for name in alone} == alone
    assert set(steered) - set(alone) == {"controller"}
    other = versions_of(known, replace(centre, overrides={"fastest_mps": 1.0}))
    assert {name for name in steered if steered[name] != other[name]} == {"controller"}
    assert versions_of(known, controller_entry("hold", "helicopter"))["controller"] != steered["controller"]


def test_a_tracker_is_made_of_what_it_imports_and_of_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A change in a module shows in the hash of what imports it, however indirectly."""
    package = tmp_path / "trackers"
    package.mkdir()
    (package / "leaf.py").write_text("x = 1\n")
    (package / "middle.py").write_text("from trackers.leaf import x\n")
    (package / "mine.py").write_text("from trackers import middle\n")
    (package / "other.py").write_text("import numpy\n")
    monkeypatch.setattr("benchmarks.run.versions._ROOT", tmp_path)

    def hashes() -> list[str]:
        _modules_hash.cache_clear()
        return [_modules_hash(f"trackers.{name}") for name in ("mine", "other")]

    before = hashes()
    (package / "leaf.py").write_text("x = 2\n")
    after = hashes()
    _modules_hash.cache_clear()
    assert before[0] != after[0]
    assert before[1] == after[1]


def test_imports_are_found_in_both_forms(tmp_path: Path) -> None:
    file = tmp_path / "a.py"
    file.write_text("import trackers.b\nfrom trackers import c\nimport numpy\nfrom trackers.registry import register\n")
    found = _imported(file)
    assert "trackers.b" in found
    assert "trackers.c" in found
    assert not any(name.startswith("numpy") or name == "trackers.registry" for name in found)
