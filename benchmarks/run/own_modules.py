"""Users' own modules: found by name or as a file, imported in every process before anything that they register."""

from __future__ import annotations

import importlib.util
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

from benchmarks.run.imports import OURS, ROOT, is_users
from sim.checks import check


def load_modules(modules: Sequence[str]) -> None:
    """Import users' own modules, so that they register their trackers, scenarios, metrics and so on.

    Args:
        modules: names, also of modules in the current folder, or files, ``folder/my_tracker.py``, whose folder is then
            searched too, last.

    Raises:
        ValueError: if one cannot be imported; names the file and line. Also for a name that another module has.
    """
    for module in modules:
        name = _name_of_file(module) if module.endswith(".py") else _name_here(module)
        try:
            importlib.import_module(name)
        except (Exception, SystemExit) as error:
            # Its author needs the line of the fault, not our call stack.
            expected = f"modules: expected one that can be imported, got {module!r}{_place_in_users_code(error)}"
            raise ValueError(f"{expected}: {type(error).__name__}: {error}") from None


def _name_of_file(file: str) -> str:
    """Return the name under which a file is imported: Python must find this file and no other."""
    path = Path(file).resolve()
    check("modules", path.is_file(), "a file that exists, or a module's name", repr(file))
    _search(path.parent)
    spec = importlib.util.find_spec(path.stem)
    found = None if spec is None or spec.origin is None else Path(spec.origin).resolve()
    same_name = f"{file!r}, whose name {found or 'a folder'} has"
    check("modules", found == path, "a file whose name no other module has", same_name)
    return path.stem


def _name_here(module: str) -> str:
    """Return a module's name; the current folder is searched for it too, but no folder with the name of ours."""
    _search(Path.cwd())
    beside = Path(*module.split(".")).with_suffix(".py")
    hidden = module.partition(".")[0] in OURS and is_users(str(beside))
    check("modules", not hidden, f"the file {beside}, whose folder has the name of our package", repr(module))
    return module


def _search(folder: Path) -> None:
    """Let Python search a folder, after all others and, in new processes too, after ours."""
    for each in (ROOT, folder) if _holds_our_names(folder) else (folder,):
        if str(each) not in sys.path:
            sys.path.append(str(each))
    # A file may be younger than what Python knows of its folder.
    importlib.invalidate_caches()


def _holds_our_names(folder: Path) -> bool:
    return any((folder / name).exists() or (folder / f"{name}.py").exists() for name in OURS)


def _place_in_users_code(error: BaseException) -> str:
    """Return the file and line of a user's code that an error came from, or nothing."""
    if isinstance(error, SyntaxError):
        return f", {error.filename}, line {error.lineno}"
    lines = [frame for frame in traceback.extract_tb(error.__traceback__) if is_users(frame.filename)]
    return f", {lines[-1].filename}, line {lines[-1].lineno}" if lines else ""
