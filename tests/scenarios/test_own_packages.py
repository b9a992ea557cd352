"""Foreign packages of our names are told in one line, with what to do."""

from __future__ import annotations

import sys
from importlib.machinery import PathFinder
from pathlib import Path

import pytest

from benchmarks.cli.main import main
from scenarios import own_packages


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with packages of our names, which Python finds there."""
    for name in ("sim", "trackers"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text('_HOMES = {"registry": "trackers.registry"}\n')
    monkeypatch.setattr(own_packages, "_ROOT", tmp_path)
    monkeypatch.setattr(
        own_packages.importlib.util, "find_spec", lambda name: PathFinder.find_spec(name, [str(tmp_path)])
    )
    own_packages.check_own_packages()
    return tmp_path


def test_another_package_that_is_found_first_is_named(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own_packages, "_ROOT", root / "elsewhere")
    with pytest.raises(
        ImportError, match=r"sim: expected .* in .*elsewhere, got .*/sim, which Python finds first; rename"
    ):
        own_packages.check_own_packages()


def test_one_that_was_installed_over_ours_is_noticed(root: Path) -> None:
    (root / "trackers" / "__init__.py").write_text("from trackers.core import SORTTracker\n")
    with pytest.raises(ImportError, match=r"trackers: .* got another's files over it; `pip uninstall trackers`"):
        own_packages.check_own_packages()


def test_the_command_refuses_what_the_import_does(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "scenarios", None)
    assert main(["--version"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert len(err.splitlines()) == 1
