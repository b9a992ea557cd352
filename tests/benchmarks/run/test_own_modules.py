"""Users' own modules, and what is imported by whom."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from benchmarks.run import own_modules as imports
from benchmarks.run.own_modules import load_modules


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


@pytest.fixture(autouse=True)
def _search_path_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", list(sys.path))


def test_a_file_anywhere_is_imported_and_its_sources_are_those_beside_it_too(tmp_path: Path) -> None:
    (tmp_path / "my_gain.py").write_text("GAIN = 2.0\n")
    file = tmp_path / "my_own_file.py"
    file.write_text("from my_gain import GAIN\n\nTWICE = 2 * GAIN\n")
    load_modules([str(file)])
    assert sys.modules["my_own_file"].TWICE == 4.0
    assert imports.imported_files(["my_own_file"]) == [tmp_path / "my_gain.py", file]


def test_a_name_is_found_in_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "my_own_name.py").touch()
    monkeypatch.chdir(tmp_path)
    load_modules(["my_own_name"])
    assert "my_own_name" in sys.modules


@pytest.mark.parametrize(
    ("module", "told"),
    [
        ("trackers.py", r"got 'trackers\.py', whose name \S+trackers/__init__\.py has"),
        ("json.py", r"got 'json\.py', whose name \S+json/__init__\.py has"),
        ("nix.py", r"a file that exists, or a module's name, got 'nix\.py'"),
        (
            "trackers.mine",
            r"the file trackers/mine\.py, whose folder has the name of our package, got ",
        ),
        ("my_broken.py", r"got 'my_broken\.py', \S+my_broken\.py, line 2: ZeroDivisionError"),
    ],
)
def test_what_cannot_be_imported_is_told_with_its_place(
    module: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("trackers.py", "json.py", "trackers/mine.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "my_broken.py").write_text("A = 0\nB = 1 / A\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=told):
        load_modules([module])


def test_new_processes_find_our_packages_before_folders_of_the_same_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They get this search path; of an editable installation it holds no folder with our packages otherwise."""
    (tmp_path / "sim").mkdir()
    monkeypatch.setattr(sys, "path", [place for place in sys.path if Path(place).resolve() != imports.ROOT])
    (tmp_path / "my_own_third.py").touch()
    load_modules([str(tmp_path / "my_own_third.py")])
    assert sys.path[-2:] == [str(imports.ROOT), str(tmp_path)]
