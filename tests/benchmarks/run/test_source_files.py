from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.run import source_files, versions


def names(*modules: str) -> set[str]:
    """Return the names of the files that modules are made of."""
    source_files._read.cache_clear()
    found = {path.name for path in source_files.source_files(modules, ("trackers.registry",))}
    source_files._read.cache_clear()
    return found


def test_imports_are_followed_in_every_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "trackers"
    (package / "room").mkdir(parents=True)
    (package / "mine.py").write_text("import trackers.room.a\nfrom trackers.registry import register\n")
    (package / "registry.py").write_text("import trackers.other\n")
    (package / "other.py").touch()
    (package / "room" / "a.py").write_text("import numpy\nfrom trackers.room import b\n")
    (package / "room" / "b.py").write_text("def late():\n    from . import c\n")
    (package / "room" / "c.py").write_text("from ..room.d import x\n")
    (package / "room" / "d.py").write_text("x = 'learnt'\n")
    (package / "room" / "learnt.json").write_text("{}")
    (package / "room" / "another.json").write_text("{}")
    monkeypatch.setattr(source_files, "ROOT", tmp_path)
    assert names("trackers.mine") == {"mine.py", "a.py", "b.py", "c.py", "d.py", "learnt.json"}


def test_a_users_package_is_followed_and_an_installed_one_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "some_users_package"
    package.mkdir()
    (package / "track.py").write_text("import cv2\nimport json\nfrom . import model\nimport some_users_module\n")
    (package / "model.py").write_text("from numpy import linalg\nfrom trackers.types import Estimate\n")
    (tmp_path / "some_users_module.py").touch()
    monkeypatch.syspath_prepend(str(tmp_path))
    expected = {"track.py", "model.py", "some_users_module.py", "types.py"}
    assert names("some_users_package.track") == expected


def test_hashes_do_not_depend_on_where_a_folder_lies(tmp_path: Path) -> None:
    files = []
    for folder in ("a/z", "z/a"):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / folder / "one.py").write_text("1")
        (tmp_path / folder / ".." / "two.py").write_text("2")
        files.append(sorted((tmp_path / folder[0]).rglob("*.py")))
    assert [path.name for path in files[0]] != [path.name for path in files[1]]
    assert versions._hash_files(files[0]) == versions._hash_files(files[1])
