"""Environments of programs that say what they need, made once for all runs.

A program says so in a comment, as every tool of Python reads it (PEP 723, "Inline script metadata")::

    # /// script
    # dependencies = ["torch==2.13.0", "numpy"]
    # ///

``requires-python`` in it is for ``uv``, which can bring another Python; without ``uv`` the environment is one of
``venv``, of the Python that runs here. It lies in the user's cache under the program's name and a digest of this text.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

_BLOCK = re.compile(r"^# /// script\n((?:#(?: .*)?\n)+?)# ///$", re.MULTILINE)
_LAST_WORDS = 300


def needs(program: Path) -> tuple[str, ...]:
    """Return the packages that a program says it needs; () if it does not say.

    Raises:
        ValueError: if what it says is no TOML or holds no list of texts.
    """
    return _read(program)[0]


def environment_of(program: Path) -> Path:
    """Return the interpreter of a program's environment, which may not have been made yet."""
    packages, python = _read(program)
    text = "\n".join([*sorted(packages), python, f"{sys.version_info[0]}.{sys.version_info[1]}"])
    digest = hashlib.sha256(text.encode()).hexdigest()[:10]
    cache = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
    return cache / "frameout" / "environments" / f"{program.stem}-{digest}" / "bin" / "python"


def made_environment(program: Path) -> Path:
    """Return the interpreter of a program's environment; make it, and say so, if there is none.

    Raises:
        ValueError: if it cannot be made, or the program does not say what it needs.
    """
    if not program.is_file() or not needs(program):
        got = "one that does not" if program.is_file() else "no file"
        raise ValueError(f"{program}: expected a program that says in # /// script which packages it needs, got {got}")
    python = environment_of(program)
    if python.is_file():
        return python
    packages, wanted = _read(program)
    folder, uv = python.parents[1], shutil.which("uv")
    by = "uv" if uv else "venv and pip"
    print(f"making the environment of {program.name} in {folder} by {by}: {', '.join(packages)} …", file=sys.stderr)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".making-") as making:
        if folder.exists() and not python.is_file():  # Its interpreter has been removed from this machine.
            folder.rename(Path(making) / "broken")
        new = Path(making) / "environment"
        if uv:
            _run(program, uv, "venv", "-q", "--python", wanted or sys.executable, new)
            _run(program, uv, "pip", "install", "-q", "--python", new / "bin" / "python", *packages)
        else:
            _run(program, sys.executable, "-m", "venv", new)
            _run(program, new / "bin" / "python", "-m", "pip", "install", "-q", *packages)
        try:
            new.rename(folder)
        except OSError:
            # Another run has made it meanwhile.
            if not python.is_file():
                raise
    return python


def _read(program: Path) -> tuple[tuple[str, ...], str]:
    """Return the packages that a program needs, and which Python."""
    found = _BLOCK.search(program.read_text("utf-8-sig", errors="replace"))
    if found is None:
        return (), ""
    text = "".join(line[2:] or "\n" for line in found[1].splitlines(keepends=True))
    try:
        said = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{program}: expected TOML between # /// script and # ///, got {error}") from None
    packages = said.get("dependencies", [])
    if not isinstance(packages, list) or not all(isinstance(each, str) for each in packages):
        raise ValueError(f"{program}: expected a list of packages as dependencies, got {packages!r}")
    return tuple(packages), str(said.get("requires-python", ""))


def _run(program: Path, *words: str | Path) -> None:
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False)
    if done.returncode:
        said = (done.stderr.strip() or done.stdout.strip())[-_LAST_WORDS:]
        raise ValueError(f"{program}: expected an environment with {', '.join(needs(program))}, got: {said}")
