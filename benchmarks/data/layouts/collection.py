"""Collections: all sequences of a folder of ``--real``, read by its layout.

``--real`` takes a data set's folder, or a sequence: its folder of pictures, with all sequences that share it, or its
file of labels, in the data set.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from tempfile import gettempdir

from benchmarks.contract.judging import USUAL_RATE_HZ
from benchmarks.contract.text import printable
from benchmarks.data.layouts.layout import Target, layouts
from benchmarks.data.sequences import BoxedSequence, boxed_sequence
from sim.checks import check

_LEVELS = 5
"""How far above a sequence's files its data set's folder may be."""


@dataclass(frozen=True)
class Collection:
    """Sequences that are ranked together, e.g. a data set; or a single one.

    Attributes:
        name: of the data set's folder, or of the sequence.
        sequences: in order of their names.
        unusable: what is wrong with those that could not be read, a line each.
        notes: what a user should know of how all of it was read, a line each.
    """

    name: str
    sequences: tuple[BoxedSequence, ...]
    unusable: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def read_collections(
    paths: Sequence[Path], layout: str = "", target: Target = None, rate_hz: float | None = None
) -> list[Collection]:
    """Return the collections of paths, one each; sequences that cannot be read are named in them.

    Args:
        layout: of ``layouts()``; "" = it is recognised: the first one with sequences is taken.
        target: in files of several, see ``Target``.
        rate_hz: frames a second of all pictures; None = as files say, else ``USUAL_RATE_HZ``.

    Raises:
        ValueError: for a path that is missing or of another layout; two collections of one name; and if no sequence
            can be read.
    """
    known = layouts()
    check("layout", layout in ("", *known), f"one of {', '.join(known)}", repr(layout))
    if rate_hz is not None:
        check("rate_hz", 0 < rate_hz < float("inf"), "a number of frames a second > 0", f"{rate_hz:g}")
    found = [_collection(path.resolve(), layout, target, rate_hz) for path in paths]
    names = [each.name for each in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    check("real", not twice, "recordings of different names", f"two called {', '.join(twice)}")
    if not any(each.sequences for each in found):
        raise ValueError(next(line for each in found for line in each.unusable))
    return found


def _collection(path: Path, layout: str, target: Target, rate_hz: float | None) -> Collection:
    check("real", path.exists(), "folders that exist", repr(str(path)))
    known = layouts()
    searched = [known[layout].find] if layout else [each.find for each in known.values()]
    above = list(islice(_above(path), _LEVELS))
    places = [(path, find) for find in searched] + [(root, find) for find in searched for root in above]
    # Around a path those that have it among their places.
    found = ([each for each in find(root) if root == path or path in each.places] for root, find in places)
    sources = next(filter(None, found), [])
    some = f"the layout of one of {', '.join(known)} (see frameout bench --help)"
    wanted = known[layout].looks_for if layout else some
    check("real", bool(sources), wanted, f"{str(path)!r}, which has none")
    sequences: list[BoxedSequence] = []
    unusable, rates_hz = [], set[float]()
    for number, source in enumerate(sorted(sources, key=lambda each: printable(each.name))):
        try:
            told = source.read(target)
            read = boxed_sequence(told)
            sequences.append(replace(read, rate_hz=rate_hz or read.rate_hz, number=number))
            rates_hz.add(told.rate_hz)
        except ValueError as error:
            unusable.append(str(error))
    name = sequences[0].name if len(sources) == len(sequences) == 1 else printable(path.name)
    usual = f"{name}: files tell no rate, {USUAL_RATE_HZ:g} pictures a second are taken (--rate-hz)"
    return Collection(name, tuple(sequences), tuple(unusable), (usual,) if rate_hz is None and 0.0 in rates_hz else ())


def _above(path: Path) -> Iterator[Path]:
    """Yield the folders above a path that may be a data set's, from the nearest on: none with all of a person's or a
    machine's folders.
    """
    for each in path.parents:
        if each in (Path(each.anchor), Path.home(), Path(gettempdir())):
            return
        yield each
        if each.is_mount():
            return
