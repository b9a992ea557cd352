"""Trackers that run in this process, and as a program in one of their own, with the same answers: they calculate by
what every NumPy does alike. Importing this registers them; ``python followers.py NAME`` serves one.
"""

import sys
from dataclasses import dataclass

import numpy as np

try:
    from trackers.gaps import Bridge
    from trackers.registry import register
    from trackers.types import Estimate, Track
except ImportError:
    from frameout_client import Bridge, Estimate, Track

    def register(name, **how):
        """Return what changes nothing."""
        return lambda tracker: tracker


@dataclass
class Parameters:
    shaken_px: float = 3.0


@register("follows_one", role="external", summary="drifts, by its pictures", suites=("frame-out", "stereo", "follow"))
class One:
    """Drifts by what its pictures, its camera and its random numbers hold, and gives a posterior."""

    Parameters = Parameters

    def __init__(self, parameters, rng):
        self._shaken_px, self._rng = parameters.shaken_px, rng

    def initialise(self, observation, box_xyxy):
        self._box_xyxy, self._first = box_xyxy, observation.image_rgb[:20, ::-1]
        self._sum = int(observation.image_rgb.sum())

    def update(self, observation):
        change = int(observation.image_rgb.sum()) - self._sum + int(self._first[0, 0, 0])
        right = 0 if observation.right_rgb is None else int(observation.right_rgb[..., 0].sum()) % 7
        step = self._rng.normal(0.0, self._shaken_px, 2) + np.array([change % 5 - 2, right])
        if observation.ego is not None:
            step = step + observation.ego.T_world_camera[:2, 3] % 1.0
        self._box_xyxy = self._box_xyxy + np.tile(step, 2)
        middle = 0.5 * (self._box_xyxy[:2] + self._box_xyxy[2:])
        inside = bool(((middle >= 0) & (middle < 2 * observation.camera.centre_px)).all())
        cloud = (middle + self._rng.integers(-40, 40, (50, 2))).astype(np.float32)
        return Estimate(
            middle,
            self._box_xyxy,
            in_view_probability=np.float32(inside),
            particles_px=cloud,
            depth_m=1.5 + 0.1 * (change % 9),
            mask=observation.image_rgb[..., 0] > 128,
        )


class Halfway:
    """Bridges a gap by what it has learnt: how far targets go in a frame."""

    def __init__(self):
        self._step_px = np.zeros(2)

    def learn(self, pieces):
        steps = [step for piece in pieces for step in np.diff(piece.position_px, axis=0) if np.isfinite(step).all()]
        self._step_px = np.array([sum(step) / len(step) for step in zip(*steps, strict=True)])

    def extrapolate(self, past, count, around):
        known = past.position_px[np.isfinite(past.position_px).all(axis=1)]
        ahead = np.arange(1, count + 1)[:, None] * self._step_px + len(around.mates) % 2
        return Bridge(known[-1] + ahead, np.tile(9.0 * np.eye(2), (count, 1, 1)))

    def interpolate(self, past, future, around):
        begin, end = (each[np.isfinite(each).all(axis=1)] for each in (past.position_px, future.position_px))
        count = future.first_frame - past.end_frame
        share = np.arange(1, count + 1)[:, None] / (count + 1)
        return Bridge(begin[-1] + share * (end[0] - begin[-1]))


OF_MANY = ("frame-out", "fish", "harbour", "follow", "toy-many")


@register("follows_many", role="external", summary="draws tracks", suites=OF_MANY)
class Many:
    """Has tracks at random, the more so the brighter its pictures are; it has all that trackers of many may have."""

    Parameters = Parameters
    decides_at = 0.4

    def __init__(self, parameters, rng):
        self._rng, self._answers, self._site_m = rng, [], 0.0
        self.gap_method = Halfway()

    def survey(self, site):
        self._site_m = site.edge_m[0] % 1.0 + site.watched_m[2]

    def start(self, background, camera):
        self._seen = sum(int(each.image_rgb.sum()) for each in background) % 11
        self._middle = camera.centre_px

    def update(self, observation):
        bright = int(observation.image_rgb.sum()) + (0 if observation.counts is None else int(observation.counts.sum()))
        tracks = []
        for identity in range(2 + (bright + self._seen) % 3):
            place = self._middle * (0.5 + self._rng.random(2)) + self._site_m
            box = np.concatenate([place - 8.0, place + np.array([8.0, 5.0])])
            line = place + np.arange(10.0).reshape(5, 2)
            estimate = Estimate(place, box, depth_m=80.0 + 5.0 * identity, heading_rad=0.3, centre_line_px=line)
            tracks.append(Track(identity, estimate, "fish", np.full(3, 2.0), float(self._rng.random())))
        self._answers.append(tracks)
        return tracks

    def revised(self):
        return [tracks[:1] for tracks in self._answers]


if __name__ == "__main__":
    from frameout_client import serve

    serve({"one": One, "many": Many}[sys.argv[1]])
