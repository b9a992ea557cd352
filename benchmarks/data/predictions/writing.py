"""Writes what trackers answered in a run as files of predictions, which other programs score.

========= ============================================================== ===============================================
format    file                                                           read by
========= ============================================================== ===============================================
``mot``   ``frameout-train/TRACKER/data/NAME.txt``                       TrackEval, beside ``frameout export SET`` of
                                                                         the same episodes with ``--format mot``
``vot``   ``TRACKER/baseline/NAME/NAME_001.txt``, ``…_confidence.value`` the VOT toolkit, beside ``--format vot``
========= ============================================================== ===============================================

Boxes stand as they were answered; one that was not is of the size of the first one, or without one of none, about the
position. In ``vot`` a mask stands where one was answered. A tracker of one target has the identity 1 in ``mot``.
Confidences are those of tracks, or the probability of being in view; -1 in ``mot``, and nothing in ``vot``, where there
is none. A tracker that decides with hindsight has these answers. Of several runs in an episode the first is written. A
frame without an answer has no row, or ``0``. ``mot`` counts all pictures of a real sequence; ``vot`` begins with the
first one that shows the target.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path

from benchmarks.contract.rows import REAL
from benchmarks.data.estimates.block_file import Answered, Facts, facts_in, read_block
from benchmarks.data.exports.destination import whole_folder
from benchmarks.data.exports.mot import SPLIT
from benchmarks.data.mot_text import FIRST, box_of, first_box, mot_rows
from benchmarks.data.sequence_names import sequence_name, set_name
from sim.checks import check, check_choice
from trackers.regions import Mask, Rectangle, Special
from trackers.types import Estimate

WRITTEN = ("mot", "vot")
_Numbers = Callable[[str, tuple[str, ...]], dict[tuple[str, int], int]]
"""See ``_first_numbers``."""


def write_predictions(directory: Path, format: str, out: str) -> int:
    """Write the kept answers of a result folder into ``out``, see ``whole_folder``; return the number of files.

    Raises:
        ValueError: for another format, a folder without estimates, ``vot`` of tracks of many targets, ``mot`` of real
            sequences that cannot be read any more, two sequences of one name, and an ``out`` that holds something.
    """
    check_choice("format", format, WRITTEN)
    with whole_folder(out) as folder:
        found, numbers = facts_in(directory), cache(_first_numbers)
        for path, facts in found.items():
            block = read_block(path)
            check("format", format == "mot" or not facts.many, "mot, for tracks of many targets", format)
            for name, lines in _files(facts, block.answered[0], format, numbers).items():
                target = folder / name
                wanted = "sequences of different names, as their files have"
                check("estimates", not target.exists(), wanted, f"two called {target.stem}")
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    return len(found)


def _first_numbers(suite: str, recorded: tuple[str, ...]) -> dict[tuple[str, int], int]:
    """Return collection and number of real sequences → number of the first frame, before which pictures may stand."""
    from benchmarks.data.real import recorded_episodes  # It imports the readers of all layouts.

    found = recorded_episodes({"suite": suite, "recorded": recorded})
    return {(each.preset, each.seed): FIRST + each.extent[1] for each in found}


def _first_number(facts: Facts, numbers: _Numbers) -> int:
    """Return the number of an episode's first frame in MOT.

    Raises:
        ValueError: for a real sequence that cannot be read any more.
    """
    key, heading = facts.key, facts.heading
    if key.scenario != REAL:
        return FIRST
    number = numbers(heading["suite"], tuple(heading["recorded"])).get((key.preset, key.seed))
    wanted = f"the pictures of {heading['sequence']}, whose numbers rows of MOT have"
    check("estimates", number is not None, wanted, "none that can be read")
    assert number is not None
    return number


def _files(facts: Facts, answered: Answered, format: str, numbers: _Numbers) -> dict[str, Iterable[str]]:
    """Return path → lines of the files of a tracker in an episode."""
    key, heading = facts.key, facts.heading
    name = heading.get("sequence", "")
    if key.scenario != REAL:
        name = sequence_name(set_name(key.scenario, key.preset, renderer=key.renderer), key.seed)
    tracker = f"{key.controller}+{key.tracker}" if key.controller else key.tracker
    if format == "mot":
        answers = answered.answers if answered.revised is None else answered.revised
        return {f"{SPLIT}/{tracker}/data/{name}.txt": mot_rows(answers, _first_number(facts, numbers))}
    estimates = [answer for answer in answered.answers if isinstance(answer, Estimate)]
    probabilities = [each.in_view_probability for each in estimates]
    confidences = ["" if each is None else repr(float(each)) for each in probabilities]
    place = f"{tracker}/baseline/{name}/{name}_001"
    return {f"{place}.txt": _regions(estimates), f"{place}_confidence.value": confidences}


def _regions(estimates: Sequence[Estimate]) -> Iterator[str]:
    first = first_box(estimates)
    yield str(Special(1))
    for each in estimates[1:]:
        box = box_of(each, first)
        if each.mask is not None and each.mask.any():
            yield str(Mask(each.mask))
        else:
            yield str(Special(0) if box is None else Rectangle(box))
