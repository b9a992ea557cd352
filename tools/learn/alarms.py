"""``python -m tools learn-alarms``: learn from development episodes of the harbour what its baselines, its blind
tracker, and paper D's method with a learnt confidence ship.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pandas as pd
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
from trackers.blind.harbour_blind import PLACE_COLUMNS, PLACES_FILE
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
        answers, stays = (
            pd.concat(each, keys=episodes, names=["preset", "seed"]) for each in zip(*samples, strict=True)
        )
        print(write(CONFIDENCE_PATHS[self.of], learn_confidences(answers, names), command))
        if self.of == "baselines":
            print(write(PLACES_PATH, {"places": often_visited(stays).round(2).tolist()}, command))
        return 0


def episode_samples(preset: str, seed: int, names: Sequence[str]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Run trackers on an episode and judge their tracks as the suite does; return what it teaches.

    Returns:
        Answers, a row for each track and frame: its evidence, ``tracker``, ``found`` (whether it lies on an intruder)
        and ``weight``, one over the root of its identity's frames: a moored boat is one error, however long it lies
        there. Stays, a row for each intruder and frame on which it is judged: its place and size, see
        ``PLACE_COLUMNS``, ``intruder`` and ``frame``.
    """
    episode = HARBOUR.episode(preset, seed)
    start = episode.start
    trackers = {name: entry(name).create(np.random.default_rng(seed)) for name in names}
    for tracker in trackers.values():
        begin(tracker, start)
    pose = start.background[0].ego
    assert isinstance(pose, EgoPose)
    assert start.site is not None
    volume = place(start.site, start.camera, pose.T_world_camera)
    matchers = {name: Matcher() for name in names}
    answers, stays = [], []
    for frame in range(HARBOUR.presets[preset].frame_count):
        taken = episode.step()
        assert isinstance(taken.truth, HarbourTruth)
        objects = objects_of(taken.truth)
        judged = np.flatnonzero(objects.judged)
        offsets_m = (objects.place_m[judged] - volume.centre_m) @ volume.axes.T
        places = pd.DataFrame(np.hstack([offsets_m, objects.size_m[judged]]), columns=PLACE_COLUMNS[:-1])
        stays.append(places.assign(intruder=judged, frame=frame))
        for name, tracker in trackers.items():
            answered = answers_of(tracker.update(taken.observation), start.camera, taken.truth.T_world_camera)
            matches = matchers[name].match(objects, answered)
            evidence = pd.DataFrame(tracker.evidence, columns=EVIDENCE)
            evidence = evidence.assign(tracker=name, found=matches.target >= 0, identity=answered.identity)
            answers.append(evidence[~matches.excused])
    judged_answers = pd.concat(answers, ignore_index=True)
    frames = judged_answers.groupby(["tracker", "identity"])["found"].transform("size")
    return judged_answers.assign(weight=1.0 / np.sqrt(frames)), pd.concat(stays, ignore_index=True)


def learn_confidences(answers: pd.DataFrame, trackers: Sequence[str]) -> dict[str, Any]:
    """Return the weights of the evidence of trackers, from the answers of ``episode_samples``."""
    weights = {}
    for name in trackers:
        own = answers[answers["tracker"] == name]
        fitted = fit_weights(*(own[columns].to_numpy() for columns in (list(EVIDENCE), "found", "weight")))
        weights[name] = dict(zip(EVIDENCE, fitted.round(4).tolist(), strict=True))
    return {"weights": weights}


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


def often_visited(stays: pd.DataFrame) -> Array:
    """Return the places (P, 7) where most intruders stayed four frames running, the most visited first.

    A place is a cell as wide as the radius within which a track counts; it has the mean of what was seen there.

    Args:
        stays: of ``episode_samples``, by preset and seed.
    """
    where = list(PLACE_COLUMNS[:-1])
    cell = stays.groupby([np.floor(stays[axis] / RADIUS_M) for axis in where[:2]]).ngroup()
    who = stays.groupby(["preset", "seed", "intruder"], sort=False).ngroup()
    people = int(who.max()) + 1
    stayed = streaks(stays["frame"].to_numpy(), (cell * people + who).to_numpy(), np.ones(len(stays))).key // people
    visits = pd.Series(stayed).value_counts().sort_index().sort_values(ascending=False, kind="stable")[:_MOST_PLACES]
    means = stays[where].groupby(cell).mean().loc[visits.index]
    return np.column_stack([means, visits])
