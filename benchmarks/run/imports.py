"""Where modules lie, which are ours or a user's, and what they import."""

from __future__ import annotations

import ast
import importlib.util
import sysconfig
from collections.abc import Iterable
from functools import cache
from pathlib import Path

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


def foreign_packages() -> dict[str, Path]:
    """Return those of our packages that Python finds elsewhere than beside this one, each with the place."""
    found = {name: _place_of(name) for name in OURS}
    return {name: place for name, place in found.items() if place is not None and place.parent != ROOT}


def _place_of(top: str) -> Path | None:
    """Return the folder, or the file, that Python takes for a top module."""
    spec = importlib.util.find_spec(top)
    if spec is None:
        return None
    return Path(next(iter(spec.submodule_search_locations or (spec.origin or "",)))).resolve()


def is_users(place: str) -> bool:
    """Return whether a source file or folder exists and is neither ours nor installed nor Python's own."""
    path = Path(place).resolve()
    ours = any(path.is_relative_to(ROOT / top) for top in OURS)
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
