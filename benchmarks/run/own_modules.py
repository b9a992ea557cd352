"""Users' own modules: found by name or as a file, imported first; and which files are whose."""

from __future__ import annotations

import ast
import importlib.util
import sys
import sysconfig
import traceback
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

from sim.checks import check

ROOT = Path(__file__).resolve().parents[2]
"""Folder of our packages."""
OURS = ("sim", "trackers", "scenarios", "benchmarks")
"""Names of our packages."""
_PYTHON = Path(sysconfig.get_path("stdlib")).resolve()
_IMPORTING = ("import_module", "__import__")
_INSTALLED = {"site-packages", "dist-packages"}


def imported_files(modules: Iterable[str], *, users_alone: bool = False) -> list[Path]:
    """Return, sorted, the source files of modules and of all that they import, directly or not.

    Installed packages are left out, and so is our ``__init__``, which has no own code; with ``users_alone`` all ours.
    """
    found: dict[str, Path] = {}
    waiting = list(modules)
    while waiting:
        name = waiting.pop()
        path = None if name in found else _source_of(name)
        if path is not None and (is_users(str(path)) or not users_alone):
            found[name] = path
            # To import a module runs its package.
            waiting += [name.rpartition(".")[0], *_imports(name, path)]
    return sorted(found.values())


def _source_of(module: str) -> Path | None:
    """Return the source file of one of our modules or of a user's; None for others."""
    top = module.partition(".")[0]
    if top in OURS:
        path = ROOT.joinpath(*module.split(".")).with_suffix(".py")
        return path if path.is_file() else None
    try:
        # To find a submodule imports its package, which may be slow for an installed one; a file has none.
        whole = importlib.util.find_spec(top)
        places = [] if whole is None else whole.submodule_search_locations or [whole.origin or ""]
        has_none = whole is not None and top != module and whole.submodule_search_locations is None
        if has_none or not any(map(is_users, places)):
            return None
        spec = whole if top == module else importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return None
    origin = spec.origin if spec is not None else None
    return Path(origin) if origin is not None and origin.endswith(".py") else None


def is_users(place: str) -> bool:
    """Return whether a source file or folder exists and is neither ours nor installed nor Python's own."""
    path = Path(place).resolve()
    ours = any(path.is_relative_to(ROOT / top) for top in (*OURS, "tools"))
    installed = path.is_relative_to(_PYTHON) or not _INSTALLED.isdisjoint(path.parts)
    return place != "" and path.exists() and not ours and not installed


@cache
def _imports(module: str, path: Path) -> tuple[str, ...]:
    """Return the imported names of a file, which may be modules."""
    imported: list[str] = []
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            imported += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            source = importlib.util.resolve_name("." * node.level + (node.module or ""), package)
            imported += [source, *(f"{source}.{alias.name}" for alias in node.names)]
        elif isinstance(node, ast.Call) and getattr(node.func, "attr", getattr(node.func, "id", "")) in _IMPORTING:
            named = (each.value for each in node.args[:1] if isinstance(each, ast.Constant))
            imported += [each for each in named if isinstance(each, str) and not each.startswith(".")]
    return tuple(imported)


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
            line = users_line(error)
            place = f", {line[0]}, line {line[1]}" if line else ""
            got = f"{module!r}{place}: {type(error).__name__}: {error}"
            raise ValueError(f"modules: expected one that can be imported, got {got}") from None


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


def users_line(error: BaseException) -> tuple[str, int | None] | None:
    """Return the innermost file and line of a user's own code that an error came from; None if none did."""
    if isinstance(error, SyntaxError):
        return str(error.filename), error.lineno
    frames = [each for each in traceback.extract_tb(error.__traceback__) if is_users(each.filename)]
    return (frames[-1].filename, frames[-1].lineno) if frames else None
