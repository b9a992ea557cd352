from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from trackers.clients import environments
from trackers.clients.environments import environment_of, made_environment, needs

ROOT = Path(__file__).parents[3]
BLOCK = '# /// script\n# requires-python = ">=3.9"\n# dependencies = [\n#   "one==1.0",\n#   "two",\n# ]\n# ///\n'

MAKES = """import pathlib, sys
if sys.argv[1] == "venv":
    pathlib.Path(sys.argv[-1], "bin").mkdir(parents=True)
    pathlib.Path(sys.argv[-1], "bin", "python").touch()
"""
"""A program ``uv`` that makes an empty environment."""


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    file = tmp_path / "mine.py"
    file.write_text(f'#!/usr/bin/env python\n{BLOCK}"""A tracker."""\n')
    return file


def fake_uv(folder: Path, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a program ``uv`` that stands before others."""
    (folder / "bin").mkdir()
    (folder / "bin" / "uv").write_text(f"#!{sys.executable}\n{text}")
    (folder / "bin" / "uv").chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}")


def test_packages_are_read_from_the_block(program: Path) -> None:
    assert needs(program) == ("one==1.0", "two")
    before = environment_of(program)
    program.write_text(program.read_text().replace("1.0", "2.0"))
    assert environment_of(program) != before
    program.write_text(BLOCK.replace("\n", "\r\n"), "utf-8-sig")
    assert needs(program) == ("one==1.0", "two")
    program.write_text("print('no block')\n")
    assert needs(program) == ()


@pytest.mark.parametrize("text", ["dependencies = [", 'dependencies = "numpy"', "dependencies = [1]"])
def test_a_broken_block_is_one_line(text: str, program: Path) -> None:
    program.write_text(f"# /// script\n# {text}\n# ///\n")
    with pytest.raises(ValueError, match=r"mine\.py: expected "):
        needs(program)


def test_an_environment_is_made_once_and_says_so(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log"
    fake_uv(tmp_path, f"{MAKES}with open({str(log)!r}, 'a') as log: print(*sys.argv[1:], file=log)\n", monkeypatch)
    python = made_environment(program)
    assert python == environment_of(program)
    assert python.is_file()
    told = capsys.readouterr().err
    assert "making the environment of mine.py" in told
    assert "one==1.0, two" in told
    venv, install = log.read_text().splitlines()
    assert venv.startswith("venv -q --python >=3.9 ")
    assert install.endswith("one==1.0 two")
    assert made_environment(program) == python
    assert len(log.read_text().splitlines()) == 2
    assert not list(environment_of(program).parents[2].glob(".making-*"))


def test_one_whose_python_is_gone_is_made_anew(program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_uv(tmp_path, MAKES, monkeypatch)
    python = made_environment(program)
    python.unlink()
    python.symlink_to(tmp_path / "removed")
    (python.parent / "old").touch()
    assert made_environment(program).is_file()
    assert [each.name for each in python.parent.iterdir()] == ["python"]
    assert list(python.parents[2].iterdir()) == [python.parents[1]]


def test_one_that_cannot_be_made_leaves_nothing(program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_uv(tmp_path, "import sys\nsys.exit('no such package: one')", monkeypatch)
    with pytest.raises(ValueError, match=r"expected an environment with one==1\.0, two, got: no such package: one"):
        made_environment(program)
    assert not list(environment_of(program).parents[2].iterdir())


@pytest.mark.parametrize(
    ("text", "got"),
    [
        (None, "no file"),
        ("print(1)", "one that does not"),
        ("# /// script\n# dependencies = []\n# ///", "one that does not"),
    ],
)
def test_the_command_says_in_a_line_what_has_no_environment(text: str | None, got: str, program: Path) -> None:
    program.unlink() if text is None else program.write_text(text)
    done = subprocess.run([sys.executable, "-m", "trackers.clients", program], cwd=ROOT, capture_output=True, text=True)
    said = f"{program}: expected a program that says in # /// script which packages it needs, got {got}\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", said)


@pytest.mark.heavy
def test_venv_makes_one_without_uv(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(environments.shutil, "which", lambda name: None)
    program.write_text('# /// script\n# dependencies = ["pip"]\n# ///\n')
    assert made_environment(program).is_file()
