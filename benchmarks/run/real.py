"""Real recordings in place of simulated episodes: sequences of pictures with boxes, and tracks without pictures."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

from benchmarks.contract.entrant import Entrant
from benchmarks.contract.judging import UnreadableSequence
from benchmarks.contract.rows import FILE_NAME, REAL, BlockKey, Row, read_blocks, tidy
from benchmarks.contract.suite import Suite
from benchmarks.contract.text import counted
from benchmarks.run.contestants import entrants
from benchmarks.run.editions import Editions
from scenarios.scenario import Episode

_NEED_TRUTH = ("blind", "oracle")
"""Roles whose contestants are given the true state in metres."""


class RealContent(Protocol):
    """A sequence of pictures, or a ``Recording`` of tracks."""

    @property
    def name(self) -> str:
        """Name of the sequence or recording."""
        ...

    @property
    def fingerprint(self) -> str:
        """Hash of what is in it: rows of others are outdated. Raises UnreadableSequence if a picture is gone."""
        ...


@dataclass(frozen=True, eq=False)
class RealEpisode:
    """What takes the place of a simulated episode.

    Attributes:
        preset: collection of the sequence, or the recording of tracks.
        seed: number of the sequence in its collection; 0 of a recording, whose blocks of time are numbered in rows.
        content: what is real.
        open: returns the episode of a sequence before its first frame; None of tracks.
        recorded: arguments of ``frameout bench`` that say which recordings, and how they are read.
    """

    preset: str
    seed: int
    content: RealContent
    open: Callable[[], Episode] | None
    recorded: tuple[str, ...]

    @property
    def sequence(self) -> str:
        """Name of the sequence; "" of tracks."""
        return self.content.name if self.open else ""

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
