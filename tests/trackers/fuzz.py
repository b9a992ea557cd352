"""Fuzzing of every tracker with hostile pictures: none may raise, and every answer must be a valid estimate.

    python -m tests.trackers.fuzz --frames 2000
    python -m tests.trackers.fuzz --trackers mosaic_graph_pf --sequence 17

The second replays one sequence and lets the exception through.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Iterator

import numpy as np

from tests.trackers.hostile import Sequence, hostile_sequence
from trackers.estimate_check import check_estimate
from trackers.registry import TrackerEntry, entries
from trackers.types import Estimate

SEQUENCE_FRAMES = 25


def answers(entry: TrackerEntry, sequence: Sequence) -> Iterator[Estimate]:
    """Follow a sequence and yield every answer, checked. A box outside the picture may be refused."""
    tracker = entry.create_for_one(np.random.default_rng(0))
    first, *rest = sequence.observations
    try:
        tracker.initialise(first, sequence.box_xyxy.copy())
    except ValueError as refusal:
        if not (sequence.box_is_outside and str(refusal).startswith("box_xyxy: expected")):
            raise
        return
    for observation in rest:
        estimate = tracker.update(observation)
        check_estimate(estimate)
        check_posterior(estimate)
        yield estimate


def check_posterior(estimate: Estimate) -> None:
    """Raise ValueError for a posterior that is not finite."""
    for name in ("particles_px", "covariance_px"):
        value = getattr(estimate, name)
        if value is not None and not np.isfinite(value).all():
            raise ValueError(f"{name}: expected finite numbers or none, got others")


def names() -> list[str]:
    """Return the names of the package's own trackers that have all they need; tests register others.

    Trackers of a site, which start with its survey, have ``test_site_fuzz``.
    """
    own = {name: entry for name, entry in entries().items() if entry.tracker.__module__.startswith("trackers.")}
    return [name for name, entry in own.items() if not entry.missing() and not hasattr(entry.tracker, "survey")]


def is_stereo(entry: TrackerEntry) -> list[bool]:
    """Return for each suite of a tracker whether its observations are pairs."""
    return [suite == "stereo" for suite in entry.suites or ("the default",)]


def _fuzz(entry: TrackerEntry, frames: int) -> int:
    """Run ``frames`` frames, print faults and a summary, and return the number of faults."""
    faults, done, silent, seed, began_s = 0, 0, 0, 0, time.perf_counter()
    while done < frames:
        for stereo in is_stereo(entry):
            sequence = hostile_sequence(seed, stereo=stereo, frames=SEQUENCE_FRAMES)
            try:
                for estimate in answers(entry, sequence):
                    silent += bool(np.isnan(estimate.position_px).all())
            except Exception as fault:
                faults += 1
                print(f"{entry.name}: sequence {seed}{' stereo' * stereo}: {type(fault).__name__}: {fault}", flush=True)
            done += len(sequence.observations)
        seed += 1
    seconds = time.perf_counter() - began_s
    print(f"{entry.name}: {done} frames, {faults} faults, {silent} without an answer, {seconds:.0f} s", flush=True)
    return faults


def main(words: list[str]) -> int:
    """Fuzz, or replay one sequence; return the exit status."""
    parser = argparse.ArgumentParser(description="every tracker through hostile pictures")
    parser.add_argument("--frames", type=int, default=2000, help="of each tracker")
    parser.add_argument("--trackers", nargs="*", choices=names(), default=names())
    parser.add_argument("--sequence", type=int, help="replay this one alone, exceptions let through")
    arguments = parser.parse_args(words)
    warnings.simplefilter("error")
    chosen = [entries()[name] for name in arguments.trackers]
    if arguments.sequence is None:
        return 1 if sum([_fuzz(entry, arguments.frames) for entry in chosen]) else 0
    for entry in chosen:
        for stereo in is_stereo(entry):
            for k, estimate in enumerate(
                answers(entry, hostile_sequence(arguments.sequence, stereo=stereo, frames=SEQUENCE_FRAMES)), 1
            ):
                print(entry.name, k, estimate.position_px, estimate.in_view_probability)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
