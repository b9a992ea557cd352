"""The judge of the suite ``toy-many``: which crates have a track on them, and whether it is still the same one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from benchmarks.contract.judging import Ending, Score
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.visibility import MOSTLY_SEEN
from trackers.types import CameraCommand, Track

GATE_PX = 6.0
"""A track further off a crate's middle is not on it."""


@dataclass(frozen=True)
class Stay:
    """The frames on which one crate is there to be found, an event."""

    index: int
    name: str
    length_frames: int

    def attributes(self) -> dict[str, Any]:
        """See ``benchmarks.contract.judging.Event``."""
        return {"index": self.index, "kind": "crate", "name": self.name, "length_frames": self.length_frames}


class ManyJudge:
    """See ``benchmarks.contract.judging.Judge``. Targets are all objects; one is there while half of it is seen."""

    def __init__(self, episode: Episode, scenario: Scenario) -> None:
        self.names: tuple[str, ...] = ()

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        truth = frame.truth
        self.names = truth.names
        self.there = np.isin(truth.state, ("in", "partial")) & (truth.visible_fraction >= MOSTLY_SEEN)

    def sheet(self) -> ManySheet:
        """See ``Judge``."""
        return ManySheet(self)


class ManySheet:
    """See ``benchmarks.contract.judging.ScoreSheet``. Tracks are assigned to crates by the least sum of distances."""

    def __init__(self, judge: ManyJudge) -> None:
        self._judge = judge
        self._found: list[list[float]] = []
        self._errors_px: list[float] = []
        self._false, self._switches = 0, 0
        self._latest: dict[int, int] = {}

    def keep(self, frame: Frame, tracks: Sequence[Track]) -> None:
        """See ``ScoreSheet``."""
        said = [track for track in tracks if np.isfinite(track.estimate.position_px).all()]
        places = np.array([track.estimate.position_px for track in said]).reshape(-1, 2)
        there = self._judge.there
        away_px = np.linalg.norm(frame.truth.position_px[there][:, None] - places[None], axis=2)
        rows, columns = linear_sum_assignment(np.minimum(away_px, GATE_PX))
        error_px = np.full(len(there), np.nan)
        error_px[there] = GATE_PX
        for target, k, j in zip(np.flatnonzero(there)[rows], rows, columns, strict=True):
            if away_px[k, j] < GATE_PX:
                error_px[target] = away_px[k, j]
                identity = said[j].identity
                self._switches += self._latest.get(target, identity) != identity
                self._latest[target] = identity
        on = np.nan_to_num(error_px, nan=GATE_PX) < GATE_PX
        self._found.append([float(hit) if is_there else np.nan for hit, is_there in zip(on, there, strict=True)])
        self._errors_px += error_px[there].tolist()
        self._false += len(said) - int(on.sum())

    def scores(self, ending: Ending) -> Iterator[Score]:
        """Yield ``found_rate`` (crates that are there and have a track within 6 px), ``position_error_px`` (at most
        6 px, 6 px without a track), ``identity_switches`` and ``false_tracks`` (of an episode, and of a frame);
        ``crate_found_rate`` is the first of one crate alone.
        """
        found = np.array(self._found)
        frames = np.isfinite(found).sum(axis=0)
        for k, name in enumerate(self._judge.names):
            if frames[k]:
                yield Score(
                    "crate_found_rate", float(np.nanmean(found[:, k])), float(frames[k]), Stay(k, name, int(frames[k]))
                )
        if frames.any():
            yield Score("found_rate", float(np.nanmean(found)), float(frames.sum()))
            yield Score("position_error_px", float(np.mean(self._errors_px)), float(frames.sum()))
        yield Score("identity_switches", float(self._switches))
        yield Score("false_tracks", self._false / len(found), float(len(found)))
