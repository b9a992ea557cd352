"""Reads folders of real sequences, whose layout is recognised or chosen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.contract.printable import printable
from benchmarks.data.sequences.otb import find_otb, is_otb
from benchmarks.data.sequences.sequence import USUAL_RATE_HZ, BoxedSequence, Collection, Unread
from benchmarks.data.sequences.uav123 import find_uav123, is_uav123
from benchmarks.data.sequences.uavdt import find_uavdt, is_uavdt
from sim.checks import check

LAYOUTS = {"otb": is_otb, "uavdt": is_uavdt, "uav123": is_uav123}
"""Name → test of a folder; the first that fits is taken."""


def read_collections(
    paths: Sequence[Path], layout: str = "", target: int | None = None, rate_hz: float = USUAL_RATE_HZ
) -> list[Collection]:
    """Return the collections of paths, one each; sequences that cannot be read are named in them.

    Args:
        layout: of ``LAYOUTS``; "" = it is recognised.
        target: id of the target in files of several, see ``benchmarks.data.sequences.uavdt``.
        rate_hz: frames a second of all pictures.

    Raises:
        ValueError: for a path that is missing, empty or of another layout; two collections of one name; and if no
            sequence can be read.
    """
    check("layout", layout in ("", *LAYOUTS), f"one of {', '.join(LAYOUTS)}", repr(layout))
    check("rate_hz", 0 < rate_hz < float("inf"), "a number of frames a second > 0", f"{rate_hz:g}")
    found = [_collection(path.resolve(), layout, target, rate_hz) for path in paths]
    names = [each.name for each in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    check("real", not twice, "recordings of different names", f"two called {', '.join(twice)}")
    if not any(each.sequences for each in found):
        raise ValueError(next(line for each in found for line in each.unusable))
    return found


def _collection(path: Path, layout: str, target: int | None, rate_hz: float) -> Collection:
    check("real", path.exists(), "folders that exist", repr(str(path)))
    empty = path.is_dir() and not any(path.iterdir())
    check("real", not empty, "a folder of sequences", f"{str(path)!r}, which is empty")
    chosen = layout or next((name for name, fits in LAYOUTS.items() if fits(path)), "")
    wanted = f"the layout of one of {', '.join(LAYOUTS)} (see frameout bench --help)"
    check("real", bool(chosen), wanted, f"{str(path)!r}, which has none of them")
    check("target", target is None or chosen == "uavdt", "none but for files of several targets (uavdt)", target)
    unread = sorted(_find(path, chosen, target), key=lambda sequence: sequence.name)
    names = [each.name for each in unread]
    twice = sorted({name for name in names if names.count(name) > 1})
    check(printable(path.name), not twice, "sequences of different names", f"two called {', '.join(twice)}")
    sequences: list[BoxedSequence] = []
    unusable = []
    for number, each in enumerate(unread):
        try:
            sequences.append(replace(each.read(), rate_hz=rate_hz, number=number))
        except ValueError as error:
            unusable.append(str(error))
    name = sequences[0].name if len(unread) == len(sequences) == 1 else printable(path.name)
    return Collection(name, tuple(sequences), tuple(unusable))


def _find(path: Path, layout: str, target: int | None) -> list[Unread]:
    if layout == "uavdt":
        return find_uavdt(path, target)
    return find_otb(path) if layout == "otb" else find_uav123(path)
