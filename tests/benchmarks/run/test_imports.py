from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.run import imports


def names(*modules: str) -> set[str]:
    """Return the names of the files that modules are made of."""
    imports._imports.cache_clear()
    found = {path.name for path in imports.imported_files(modules)}
    imports._imports.cache_clear()
    return found


def test_imports_are_followed_in_every_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "trackers"
    (package / "room").mkdir(parents=True)
    (package / "mine.py").write_text("import trackers.room.a\nfrom trackers.alone import register\n")
    (package / "alone.py").touch()
    (package / "room" / "a.py").write_text("import numpy\nfrom trackers.room import b\n")
    (package / "room" / "b.py").write_text("def late():\n    from . import c\n")
    (package / "room" / "c.py").write_text("from ..room.d import x\n")
    (package / "room" / "d.py").write_text("x = 1\n")
    (package / "room" / "another.py").touch()
    monkeypatch.setattr(imports, "ROOT", tmp_path)
    assert names("trackers.mine") == {"mine.py", "alone.py", "a.py", "b.py", "c.py", "d.py"}


def test_a_users_package_is_followed_and_an_installed_one_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "some_users_package"
    package.mkdir()
    (package / "track.py").write_text("import cv2\nimport json\nfrom . import model\nimport some_users_module\n")
    (package / "model.py").write_text("from numpy import linalg\nfrom trackers.types import Estimate\n")
    (tmp_path / "some_users_module.py").touch()
    monkeypatch.syspath_prepend(str(tmp_path))
    expected = {"track.py", "model.py", "some_users_module.py"}
    assert names("some_users_package.track") == {*expected, "types.py"}
    users = imports.imported_files(["some_users_package.track"], users_alone=True)
    assert {path.name for path in users} == expected
