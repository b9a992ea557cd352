"""Reads folders of real sequences, whose layout is recognised or chosen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.sequences.otb import is_otb, read_otb
from benchmarks.sequences.sequence import USUAL_RATE_HZ, BoxedSequence, Collection
from benchmarks.sequences.uav123 import is_uav123, read_uav123
from benchmarks.sequences.uavdt import is_uavdt, read_uavdt
from sim.checks import check

LAYOUTS = {"otb": is_otb, "uavdt": is_uavdt, "uav123": is_uav123}
"""Name → test of a folder; the first that fits is taken."""


def read_collections(
    paths: Sequence[Path], layout: str = "", target: int | None = None, rate_hz: float = USUAL_RATE_HZ
) -> list[Collection]:
    """Return the collections of paths, one each.

    Args:
        layout: of ``LAYOUTS``; "" = it is recognised.
        target: id of the target in files of several, see ``benchmarks.sequences.uavdt``.
        rate_hz: frames a second of all pictures.

    Raises:
        ValueError: for a path that is missing, empty, of another layout, or wrong; two collections of one name.
    """
    check("layout", layout in ("", *LAYOUTS), f"one of {', '.join(LAYOUTS)}", repr(layout))
    check("rate_hz", 0 < rate_hz < float("inf"), "a number of frames a second > 0", f"{rate_hz:g}")
    found = [_collection(path.resolve(), layout, target, rate_hz) for path in paths]
    names = [each.name for each in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    check("real", not twice, "recordings of different names", f"two called {', '.join(twice)}")
    return found


def _collection(path: Path, layout: str, target: int | None, rate_hz: float) -> Collection:
    check("real", path.exists(), "folders that exist", repr(str(path)))
    empty = path.is_dir() and not any(path.iterdir())
    check("real", not empty, "a folder of sequences", f"{str(path)!r}, which is empty")
    chosen = layout or next((name for name, fits in LAYOUTS.items() if fits(path)), "")
    wanted = f"the layout of one of {', '.join(LAYOUTS)} (see frameout bench --help)"
    check("real", bool(chosen), wanted, f"{str(path)!r}, which has none of them")
    check("target", target is None or chosen == "uavdt", "none but for files of several targets (uavdt)", target)
    sequences = _read(path, chosen, target)
    names = [each.name for each in sequences]
    twice = sorted({name for name in names if names.count(name) > 1})
    check(path.name, not twice, "sequences of different names", f"two called {', '.join(twice)}")
    name = sequences[0].name if len(sequences) == 1 else path.name
    timed = (replace(each, rate_hz=rate_hz) for each in sequences)
    return Collection(name, tuple(sorted(timed, key=lambda sequence: sequence.name)))


def _read(path: Path, layout: str, target: int | None) -> list[BoxedSequence]:
    if layout == "uavdt":
        return read_uavdt(path, target)
    return read_otb(path) if layout == "otb" else read_uav123(path)
