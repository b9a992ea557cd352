"""Real recordings in place of simulated episodes: sequences of pictures with boxes, and tracks without pictures."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.contract.judging import Recording
from benchmarks.contract.printable import printable
from benchmarks.contract.rows import FILE_NAME, REAL, BlockKey, Row, read_blocks, tidy
from benchmarks.contract.suite import Suite, suites
from benchmarks.contract.text import counted
from benchmarks.data.sequences.episode import USUAL_FOCAL
from benchmarks.data.sequences.reading import read_collections
from benchmarks.data.sequences.sequence import USUAL_RATE_HZ, BoxedSequence, UnreadableSequence
from benchmarks.run.contestants import Entrant, entrants
from benchmarks.run.editions import Editions
from sim.checks import check

_NEED_TRUTH = ("blind", "oracle")
"""Roles whose contestants are given the true state in metres."""


@dataclass(frozen=True, eq=False)
class RealEpisode:
    """What takes the place of a simulated episode.

    Attributes:
        preset: collection of the sequence, or the recording of tracks.
        seed: number of the sequence in its collection; 0 of a recording, whose blocks of time are numbered in rows.
        content: what is real.
        recorded: arguments of ``frameout bench`` that say which recordings, and how they are read.
    """

    preset: str
    seed: int
    content: BoxedSequence | Recording
    recorded: tuple[str, ...]

    @property
    def sequence(self) -> str:
        """Name of the sequence; "" of tracks."""
        return self.content.name if isinstance(self.content, BoxedSequence) else ""

    @property
    def scene(self) -> str:
        """``scene`` of ``editions``: name and content; "" of a sequence that lacks a picture, which gets no row."""
        try:
            return f"{self.content.name} {self.content.fingerprint}"
        except UnreadableSequence:
            return ""

    @property
    def columns(self) -> Row:
        """Columns of its rows alone."""
        named = {"sequence": self.sequence} if self.sequence else {}
        return {**named, "recorded": list(self.recorded)}


def trackers_on_pictures(suite: Suite) -> dict[str, Entrant]:
    """Return the trackers of a suite that need nothing but pictures, by name."""
    return {name: each for name, each in entrants(suite.name).items() if each.role not in _NEED_TRUTH}


def up_to_date_on(
    episodes: Sequence[RealEpisode], suite: str, editions: Mapping[str, Editions], out: Path
) -> tuple[set[BlockKey], list[str]]:
    """Return the blocks in a folder that present contestants made on the present recordings, and messages about others.

    Rows of other editions, of recordings that have changed or are gone, and of a recording that a stopped run left in
    part, are moved to another file; so are those of other trackers on what has changed, which would be compared with
    rows on what it is now.

    Args:
        editions: tracker → present ``editions`` but for ``scene``, see ``editions_on_recordings``.

    Returns:
        Keys; all blocks of a recording of tracks are one, of seed 0.
    """
    if not (out / FILE_NAME).is_file():
        return set(), []
    blocks, known = read_blocks(out), {(each.preset, each.seed): each for each in episodes}
    presets = {each.preset for each in episodes}
    groups: dict[BlockKey, list[BlockKey]] = {}
    for key, rows in blocks.items():
        if (key.suite, key.scenario) == (suite, REAL) and key.preset in presets:
            groups.setdefault(replace(key, seed=0) if "blocks" in rows[0] else key, []).append(key)
    compared = {(key.preset, key.seed) for key in groups} & {place for place, each in known.items() if each.sequence}
    if compared:
        # All of their pictures are read, which takes minutes for large sets.
        print(f"note: comparing {counted(len(compared), 'sequence')} with their rows …", file=sys.stderr, flush=True)
    have, outdated = set[BlockKey](), set[BlockKey]()
    for whole, keys in groups.items():
        episode, now = known.get((whole.preset, whole.seed)), editions.get(whole.tracker)
        scene = {"scene": None if episode is None else episode.scene}
        heads = [blocks[key][0] for key in keys]
        made = [head.get("editions", {}) for head in heads]
        current = all(each == (each if now is None else now) | scene for each in made)
        if not current or any(head.get("blocks", 1) != len(keys) for head in heads):
            outdated.update(keys)
        elif now is not None:
            have.add(whole)
    return have, list(filter(None, [tidy(out, outdated)]))


def check_no_layout(layout: str, target: int | None, rate_hz: float) -> None:
    """Raise ValueError for arguments of folders of pictures where there are none."""
    told = {"layout": (layout, ""), "target": (target, None), "rate_hz": (rate_hz, USUAL_RATE_HZ)}
    for name, (mine, default) in told.items():
        check(name, mine == default, "none but with --real and a suite that judges pictures", repr(str(mine)))


def real_episodes(
    suite: Suite, paths: Sequence[Path], layout: str, target: int | None, rate_hz: float
) -> tuple[tuple[RealEpisode, ...], list[str]]:
    """Return the sequences or recordings of paths, and what is wrong with those that cannot be read, a line each.

    What a user should know of how they were read is printed to stderr.

    Raises:
        ValueError: for a suite that judges nothing real, and if nothing can be read.
    """
    if suite.on_sequences is None:
        check_no_layout(layout, target, rate_hz)
    words = ["--layout", layout] if layout else []
    words += [] if target is None else ["--target", str(target)]
    words += [] if rate_hz == USUAL_RATE_HZ else ["--rate-hz", f"{rate_hz:g}"]
    recorded = ("--real", *map(printable, paths), *words)
    if suite.on_sequences is not None:
        collections = read_collections(paths, layout, target, rate_hz)
        notes = [f"the sequences tell no focal length: {USUAL_FOCAL:g} times the longer side of the picture is taken"]
        notes += [note for each in collections for sequence in each.sequences for note in sequence.notes]
        unusable = [line for each in collections for line in each.unusable]
        found: list[tuple[str, int, BoxedSequence | Recording]]
        found = [(each.name, one.number, one) for each in collections for one in each.sequences]
    elif suite.recordings is not None:
        recordings, notes, unusable = suite.recordings(paths)
        found = [(each.name, 0, each) for each in recordings]
    else:
        able = sorted(name for name, each in suites().items() if each.recordings or each.on_sequences)
        raise ValueError(f"real: expected a suite that judges recordings ({', '.join(able)}), got {suite.name}")
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    return tuple(RealEpisode(*each, recorded) for each in found), unusable
