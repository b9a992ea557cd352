"""Reads real recordings: sequences of pictures with boxes, and tracks without pictures."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from benchmarks.contract import suite as registry
from benchmarks.contract.judging import Judge, Recording, UnreadableSequence, check_no_layout
from benchmarks.contract.rows import REAL, Row
from benchmarks.contract.suite import Suite, suites
from benchmarks.contract.text import printable
from benchmarks.data.layouts.collection import read_collections
from benchmarks.data.layouts.layout import Target
from benchmarks.data.sequences import USUAL_FOCAL, BoxedSequence, SequenceEpisode
from benchmarks.data.tracked import TrackedEpisode, TrackedSequence, read_tracked
from benchmarks.data.tracks import read_each
from benchmarks.run.episodes import EpisodeSpec
from scenarios.scenario import Episode
from scenarios.truth import TruthExtent
from sim.checks import check


@dataclass(frozen=True, eq=False)
class RealEpisode(EpisodeSpec):
    """A real sequence of pictures, or a recording of tracks.

    Attributes:
        preset: collection of the sequence, or the recording of tracks.
        seed: number of the sequence in its collection; 0 of a recording, whose blocks of time are numbered in rows.
        recorded: arguments of ``frameout bench`` that say which recordings, and how they are read.
    """

    preset: str
    seed: int
    recorded: tuple[str, ...]
    content: BoxedSequence | TrackedSequence | Recording
    scenario = None
    renderer = REAL

    @property
    def sequence(self) -> str:
        """See ``EpisodeSpec``."""
        return self.content.name if isinstance(self.content, BoxedSequence | TrackedSequence) else ""

    @property
    def has_one_target(self) -> bool:
        """See ``EpisodeSpec``."""
        return isinstance(self.content, BoxedSequence)

    @property
    def extent(self) -> tuple[int, int, int]:
        """Numbers of its frames, and of the pictures of its files before and after them; of tracks none."""
        boxed = self._boxed
        return (len(boxed.box_xyxy), boxed.skipped, boxed.after) if boxed else (0, 0, 0)

    @property
    def pictures(self) -> tuple[str, ...]:
        """``FOLDER/NAME`` of each of its pictures, which files of annotations name; of tracks none."""
        return tuple("/".join(each.parts[-2:]) for each in self._boxed.pictures) if self._boxed else ()

    @property
    def _boxed(self) -> BoxedSequence | None:
        content = self.content.pictured if isinstance(self.content, TrackedSequence) else self.content
        return content if isinstance(content, BoxedSequence) else None

    @cached_property
    def edition(self) -> str:
        """See ``EpisodeSpec``: name and content; "" of a sequence that lacks a picture, which gets no row."""
        try:
            return f"{self.content.name} {self.content.fingerprint}"
        except UnreadableSequence:
            return ""

    @property
    def columns(self) -> Row:
        """See ``EpisodeSpec``."""
        return ({"sequence": self.sequence} if self.sequence else {}) | {"recorded": list(self.recorded)}

    def open(self, truth: TruthExtent) -> Episode:
        """See ``EpisodeSpec``."""
        if isinstance(self.content, TrackedSequence):
            return TrackedEpisode(self.content)
        tracks = BoxedSequence(self.content.name, (), np.empty((0, 4)))
        return SequenceEpisode(self.content if isinstance(self.content, BoxedSequence) else tracks)

    def judge(self, suite: Suite, episode: Episode) -> Judge:
        """See ``EpisodeSpec``."""
        if not isinstance(self.content, BoxedSequence | TrackedSequence):
            return self.content
        assert suite.on_sequences is not None
        return suite.on_sequences.judge(episode)


def real_episodes(
    suite: Suite,
    paths: Sequence[Path],
    layout: str,
    target: Target,
    rate_hz: float | None,
    *,
    labels_serve: bool = False,
    quiet: bool = False,
) -> tuple[list[RealEpisode], list[str]]:
    """Return the sequences or recordings of paths, and what is wrong with those that cannot be read, a line each.

    What a user should know of how they were read is printed to stderr, unless it is ``quiet``.

    Args:
        labels_serve: whether pictures of many targets may be missing, since no tracker sees them.

    Raises:
        ValueError: for a suite that judges nothing real, and if nothing can be read.
    """
    if suite.on_sequences is None:
        check_no_layout(layout, target, rate_hz)
    words = ["--layout", layout] if layout else []
    words += [] if target is None else ["--target", str(target)]
    words += [] if rate_hz is None else ["--rate-hz", f"{rate_hz:g}"]
    recorded = ("--real", *map(printable, paths), *words)
    if suite.on_sequences is not None and suite.follows_many:
        one = (layout in ("", "mot")) and target is None
        check("layout", one, "mot, in which all targets of many are read, and no target", layout or f"target {target}")
        tracked, unusable = read_tracked(paths, rate_hz, labels_serve=labels_serve)
        notes = []
        found = [RealEpisode(name, each.pictured.number, recorded, each) for name, each in tracked]
    elif suite.on_sequences is not None:
        collections = read_collections(paths, layout, target, rate_hz)
        notes = [f"the sequences tell no focal length: {USUAL_FOCAL:g} times the longer side of the picture is taken"]
        notes += [note for each in collections for note in each.notes]
        notes += [note for each in collections for sequence in each.sequences for note in sequence.notes]
        unusable = [line for each in collections for line in each.unusable]
        found = [RealEpisode(each.name, one.number, recorded, one) for each in collections for one in each.sequences]
    elif suite.recordings is not None:
        tables, unusable = read_each(paths)
        recordings, notes, unjudged = suite.recordings(tables)
        unusable += unjudged
        if not recordings:
            raise ValueError(unusable[0])
        found = [RealEpisode(each.name, 0, recorded, each) for each in recordings]
    else:
        able = sorted(name for name, each in suites().items() if each.recordings or each.on_sequences)
        raise ValueError(f"real: expected a suite that judges recordings ({', '.join(able)}), got {suite.name}")
    for note in () if quiet else notes:
        print(f"note: {note}", file=sys.stderr)
    return found, unusable


def reopened(row: Row, seed: int) -> RealEpisode | None:
    """Return the sequence with this number among those that a row names; None if it cannot be read any more."""
    found = recorded_episodes(row)
    return next((each for each in found if (each.preset, each.seed) == (row["preset"], seed)), None)


def recorded_episodes(row: Row) -> list[RealEpisode]:
    """Return the sequences or recordings that a row names; none if they cannot be read any more."""
    options: dict[str, list[str]] = {}
    for word in row["recorded"]:
        if word.startswith("--"):
            options[word] = []
        else:
            options[next(reversed(options))].append(word)
    layout, target, rate = (next(iter(options.get(name, ())), None) for name in ("--layout", "--target", "--rate-hz"))
    paths = [Path(word) for word in options["--real"]]
    try:
        rate_hz = None if rate is None else float(rate)
        return real_episodes(registry.suite(row["suite"]), paths, layout or "", target, rate_hz, quiet=True)[0]
    except (ValueError, OSError):
        return []
