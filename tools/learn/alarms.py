"""``python -m tools learn-alarms``: learn from development episodes of the harbour what its baselines, its blind
tracker, and paper D's method with a learnt confidence ship.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray
from scipy.optimize import minimize

from benchmarks.cli.arguments import DevelopmentSeeds, seeds_text
from benchmarks.judges.harbour.answers import answers_of, objects_of
from benchmarks.judges.harbour.matching import RADIUS_M, Matcher
from benchmarks.judges.harbour.streaks import streaks
from scenarios.harbour.scenario import HARBOUR
from scenarios.harbour.truth import HarbourTruth
from tools.learn.swims import TRACKERS, write
from trackers.baselines.ground_linker import CONFIDENCE_FILE, EVIDENCE
from trackers.blind.harbour_blind import PLACES_FILE
from trackers.eigen_swarm.learnt_confidence import NAME as SWARM
from trackers.protocols import begin
from trackers.registry import entry
from trackers.site import place
from trackers.types import EgoPose

LEARNERS = {"baselines": ("harbour_mog2", "harbour_knn", "harbour_median"), "swarm": (SWARM,)}
"""Trackers whose confidences are learnt together."""
CONFIDENCE_PATHS = {
    "baselines": TRACKERS / "baselines" / CONFIDENCE_FILE,
    "swarm": TRACKERS / "eigen_swarm" / CONFIDENCE_FILE,
}
PLACES_PATH = TRACKERS / "blind" / PLACES_FILE
PRESETS = ("paper-d", "standard", "hard")
_RIDGE = 1e-3
_MOST_PLACES = 60
Array = NDArray[np.float64]


@dataclass(frozen=True)
class LearnAlarms:
    """Learn how the tracks of intruders look, and by the baselines where these often are, and write it to the files of
    the trackers.

    Attributes:
        of: the baselines, and with them the blind tracker, or paper D's method with a learnt confidence.
        seeds: episodes A to B - 1, or A alone, of each preset, below 10,000.
    """

    of: Literal["baselines", "swarm"] = "baselines"
    seeds: DevelopmentSeeds = range(2)
    resumes = False

    def run(self) -> int:
        """Learn; return the exit status."""
        command = f"python -m tools learn-alarms --of {self.of} --seeds {seeds_text(self.seeds)}"
        names = LEARNERS[self.of]
        episodes = [(preset, seed) for preset in PRESETS for seed in self.seeds]
        samples = Parallel(n_jobs=-1)(delayed(episode_samples)(preset, seed, names) for preset, seed in episodes)
        print(write(CONFIDENCE_PATHS[self.of], learn_confidences(samples, names), command))
        if self.of == "baselines":
            print(write(PLACES_PATH, learn_places(samples), command))
        return 0


class EpisodeSamples(NamedTuple):
    """What one episode teaches.

    Attributes:
        tracker: (R,) index of the tracker. evidence: (R, 11) of their tracks, each once a frame.
        found: (R,) whether the track lies on an intruder.
        weight: (R,) one over the root of its identity's frames: a moored boat is one error, however long it lies there.
        stays: (S, 6) places and sizes of intruders on frames on which they are judged, see ``PLACE_COLUMNS``.
        intruder: (S,) number of the intruder. frame: (S,).
    """

    tracker: NDArray[np.int64]
    evidence: Array
    found: NDArray[np.bool_]
    weight: Array
    stays: Array
    intruder: NDArray[np.int64]
    frame: NDArray[np.int64]


def learn_confidences(samples: Sequence[EpisodeSamples], trackers: Sequence[str]) -> dict[str, Any]:
    """Return the weights of the evidence of the trackers that the samples are of."""
    tracker, evidence, found, weight = (np.concatenate([each[k] for each in samples]) for k in range(4))
    weights = {}
    for k, name in enumerate(trackers):
        own = tracker == k
        fitted = fit_weights(evidence[own], found[own], weight[own])
        weights[name] = dict(zip(EVIDENCE, fitted.round(4).tolist(), strict=True))
    return {"weights": weights}


def learn_places(samples: Sequence[EpisodeSamples]) -> dict[str, Any]:
    """Return the places of intruders."""
    return {"places": often_visited(samples).round(2).tolist()}


def episode_samples(preset: str, seed: int, names: Sequence[str]) -> EpisodeSamples:
    """Run trackers on an episode and judge their tracks as the suite does."""
    episode = HARBOUR.episode(preset, seed)
    start = episode.start
    trackers = [entry(name).create(np.random.default_rng(seed)) for name in names]
    for tracker in trackers:
        begin(tracker, start)
    pose = start.background[0].ego
    assert isinstance(pose, EgoPose)
    assert start.site is not None
    volume = place(start.site, start.camera, pose.T_world_camera)
    camera = start.camera
    matchers = [Matcher() for _ in trackers]
    whose, evidence, found, identity = [], [], [], []
    stays, intruder, frames = [], [], []
    for frame in range(HARBOUR.presets[preset].frame_count):
        taken = episode.step()
        assert isinstance(taken.truth, HarbourTruth)
        objects = objects_of(taken.truth)
        judged = np.flatnonzero(objects.judged)
        offsets_m = (objects.place_m[judged] - volume.centre_m) @ volume.axes.T
        stays.append(np.hstack([offsets_m, objects.size_m[judged]]))
        intruder.append(judged)
        frames.append(np.full(len(judged), frame))
        for k, (tracker, matcher) in enumerate(zip(trackers, matchers, strict=True)):
            tracks = tracker.update(taken.observation)
            answers = answers_of(tracks, camera, taken.truth.T_world_camera)
            matches = matcher.match(objects, answers)
            told = ~matches.excused
            whose.append(np.full(int(told.sum()), k))
            evidence.append(tracker.evidence[told])
            found.append(matches.target[told] >= 0)
            identity.append(answers.identity[told] * len(trackers) + k)
    _, track = np.unique(np.concatenate(identity), return_inverse=True)
    weight = 1.0 / np.sqrt(np.bincount(track)[track])
    return EpisodeSamples(
        np.concatenate(whose),
        np.concatenate(evidence),
        np.concatenate(found),
        weight,
        np.concatenate(stays),
        np.concatenate(intruder),
        np.concatenate(frames),
    )


def fit_weights(evidence: Array, found: NDArray[np.bool_], weight: Array) -> Array:
    """Return the weights (E,) of a logistic regression, by maximum likelihood with a slight ridge on scaled evidence.

    Intruders together weigh as much as all others together.

    Args:
        evidence: (R, E), the first column constant. found: (R,), some of both. weight: (R,) of the rows.
    """
    scale = np.maximum(evidence.std(axis=0), 1e-9)
    scale[0] = 1.0
    share = 0.5 * weight / np.where(found, weight[found].sum(), weight[~found].sum())
    scaled, sign = evidence / scale, np.where(found, 1.0, -1.0)

    def loss(w: Array) -> tuple[float, Array]:
        margin = sign * (scaled @ w)
        slope = -share * sign / (1.0 + np.exp(np.clip(margin, -700.0, 700.0)))
        held = np.append(0.0, w[1:])
        return float(share @ np.logaddexp(0.0, -margin) + _RIDGE * held @ held), scaled.T @ slope + 2 * _RIDGE * held

    fitted: Array = minimize(loss, np.zeros(evidence.shape[1]), jac=True).x
    return fitted / scale


def often_visited(samples: Sequence[EpisodeSamples]) -> Array:
    """Return the places (P, 7) where most intruders stayed four frames running, the most visited first.

    A place is a cell as wide as the radius within which a track counts; it has the mean of what was seen there.
    """
    stays = np.concatenate([each.stays for each in samples])
    frame = np.concatenate([each.frame for each in samples])
    episode = np.repeat(np.arange(len(samples)), [len(each.frame) for each in samples])
    intruder = np.concatenate([each.intruder for each in samples])
    _, cell = np.unique(np.floor(stays[:, :2] / RADIUS_M), axis=0, return_inverse=True)
    _, who = np.unique(np.column_stack([episode, intruder]), axis=0, return_inverse=True)
    people = int(who.max()) + 1
    stayed = streaks(frame, cell * people + who, np.ones(len(frame))).key // people
    numbers, visits = np.unique(stayed, return_counts=True)
    order = np.argsort(-visits, kind="stable")[:_MOST_PLACES]
    means = [stays[cell == number].mean(axis=0) for number in numbers[order]]
    return np.column_stack([np.array(means), visits[order]])
