"""Layouts of real sequences on disk: what all share, and their registry.

A layout is a function in a module of this folder, or in a module of a user's own::

    @layout("mine", "NAME/boxes.txt")
    def find_mine(path):
        for file in visible(path, "*/boxes.txt"):
            yield Source(file.parent.name, (file.parent, file), lambda target, file=file: Labelled(...))
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.data.pictures import visible
from benchmarks.data.sequences import Labelled
from sim.checks import check

Target = int | str | None
"""Id or name of a target in files of many; None: the one that is seen most."""


@dataclass(frozen=True)
class Source:
    """A sequence that was found, before its files are read.

    Attributes:
        name: of the sequence, or of its folder.
        places: its folder of pictures, its file of labels: what a user may name to choose it.
        read: reads what its files say of a target. Raises ValueError for what is wrong with them, and for a target that
            they do not have.
    """

    name: str
    places: tuple[Path, ...]
    read: Callable[[Target], Labelled]


Find = Callable[[Path], Iterator[Source]]
"""Yields the sequences of a data set's folder in one layout, or the one whose folder it is; none if it has another."""


@dataclass(frozen=True)
class Layout:
    """A layout.

    Attributes:
        name: that chooses it. looks_for: the files by which it is recognised, in words. find: see ``Find``.
    """

    name: str
    looks_for: str
    find: Find


_LAYOUTS: dict[str, Layout] = {}


def layout(name: str, looks_for: str) -> Callable[[Find], Find]:
    """Return a decorator that registers a ``Find`` under a name. Raises ValueError for a name that is taken."""

    def register(find: Find) -> Find:
        ours = find.__module__.startswith(f"{__package__}.")
        known = _LAYOUTS if ours else layouts()
        check("layout", name not in known, "a name that no layout has", repr(name))
        _LAYOUTS[name] = Layout(name, looks_for, find)
        return find

    return register


def layouts() -> dict[str, Layout]:
    """Return all layouts by name, in order."""
    for module in pkgutil.iter_modules([str(Path(__file__).parent)]):
        importlib.import_module(f"{__package__}.{module.name}")
    return dict(sorted(_LAYOUTS.items()))


def folders_with(path: Path, file: str) -> Iterator[Path]:
    """Yield the folders that hold a file of a name or pattern: the path, else those a level below, else two levels.

    Below a level that has some there are but pictures, of which there may be millions.
    """
    found = (dict.fromkeys(each.parent for each in visible(path, depth + file)) for depth in ("", "*/", "*/*/"))
    yield from next(filter(None, found), ())


def check_one_target(target: Target) -> None:
    """Raise ValueError for a target that is named in a layout whose files have one."""
    check("target", target is None, "none but for files of several targets", target)
