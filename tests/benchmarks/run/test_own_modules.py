"""Users' own modules are found by name or as a file, and never in place of another module."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from benchmarks.run import imports
from benchmarks.run.own_modules import load_modules


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
