"""One track: a box of unknown size on its plane, seen as a rectangle, with a heading and a probability of existence."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.sightings import BIRD, BOAT, CAR, KINDS, PERSON, Kind, Sighting
from trackers.site import SiteView

Array = NDArray[np.float64]

STATE = 7
"""x, y, velocity along both (metres, metres a second), logarithms of length, width and height (metres)."""

_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])
_STEPS = np.diag([0.05, 0.05, 0.0, 0.0, 0.02, 0.02, 0.02])[[0, 1, 4, 5, 6]]


def rectangles(states: Array, heading_rad: float, base_m: float, roof: tuple[float, float], view: SiteView) -> Array:
    """Return the rectangles (N, 4) around the projected bodies of states (N, 7) that stand at height ``base_m``.

    A body has the box's base and, at its height, a smaller roof. NaN where a part is behind the camera.
    """
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    corners = np.where(_CORNERS[:, 2:] > 0.0, _CORNERS * (*roof, 1.0), _CORNERS)
    corners_m = (corners * np.exp(states[:, None, 4:])) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    corners_m[..., :2] += states[:, None, :2]
    corners_m[..., 2] += base_m
    px = view.project(corners_m.reshape(-1, 3))[0].reshape(len(states), 8, 2)
    return np.concatenate([px.min(axis=1), px.max(axis=1)], axis=1)


def linearised(
    state: Array, heading_rad: float, base_m: float, roof: tuple[float, float], view: SiteView
) -> tuple[Array, Array]:
    """Return the rectangle (4,) of a state (7,), and its derivatives (4, 7) by differences."""
    boxes = rectangles(np.vstack([state, state + _STEPS]), heading_rad, base_m, roof, view)
    jacobian = np.zeros((4, STATE))
    jacobian[:, [0, 1, 4, 5, 6]] = (boxes[1:] - boxes[0]).T / _STEPS.max(axis=1)
    return boxes[0], jacobian


HEADINGS_RAD = np.arange(12) * np.pi / 12
"""A box looks the same from both ends."""

_TURNS = 0.03
"""Share that moves to each neighbour from picture to picture."""
_SIDE_PX, _SIDE_SHARE = 1.5, 0.08
"""Standard deviation of a rectangle's width and height: an edge is off by about a pixel; parts without contrast."""
_AGREES_RAD = 0.2
"""Standard deviation of a body's heading about its direction of travel."""
_FORGETS = 0.8
"""Successive pictures err alike."""


class Heading:
    """Probabilities (12,) of ``HEADINGS_RAD``."""

    def __init__(self) -> None:
        """All headings are as likely."""
        self._weights = np.full(len(HEADINGS_RAD), 1.0 / len(HEADINGS_RAD))

    @property
    def likeliest_rad(self) -> float:
        """The most likely heading, 0 to pi, as the mean of it and its neighbours on the doubled angle."""
        best = int(self._weights.argmax())
        near = np.arange(best - 1, best + 2) % len(HEADINGS_RAD)
        phase = np.exp(2j * HEADINGS_RAD[near]) @ self._weights[near]
        return float(np.angle(phase) / 2 % np.pi)

    def turn(self) -> None:
        """Let it turn from picture to picture."""
        w = self._weights
        self._weights = (1.0 - 2.0 * _TURNS) * w + _TURNS * (np.roll(w, 1) + np.roll(w, -1))

    def travel(self, velocity_mps: Array, covariance: Array) -> None:
        """Take in a velocity (2,) with its covariance (2, 2): a body points along it, as far as it surely moves."""
        along = np.column_stack([np.cos(HEADINGS_RAD), np.sin(HEADINGS_RAD)])
        across = np.column_stack([-along[:, 1], along[:, 0]])
        off = across @ velocity_mps
        spread = np.einsum("ki,ij,kj->k", across, covariance, across) + (_AGREES_RAD * (along @ velocity_mps)) ** 2
        self._weigh(-0.5 * off**2 / spread)

    def look(
        self,
        rectangle: Array,
        state: Array,
        covariance: Array,
        base_m: float,
        roof: tuple[float, float],
        view: SiteView,
    ) -> None:
        """Take in a rectangle (4,) of a box of state (7,): its sides are likelier at some headings than at others."""
        log = np.zeros(len(HEADINGS_RAD))
        for k, heading_rad in enumerate(HEADINGS_RAD):
            expected, jacobian = linearised(state, heading_rad, base_m, roof, view)
            sides, slope = expected[2:] - expected[:2], jacobian[2:, 4:] - jacobian[:2, 4:]
            noise = np.diag(_SIDE_PX**2 + (_SIDE_SHARE * sides) ** 2)
            spread = slope @ covariance[4:, 4:] @ slope.T + noise
            off = rectangle[2:] - rectangle[:2] - sides
            log[k] = -0.5 * off @ np.linalg.solve(spread, off) - 0.5 * np.log(np.linalg.det(spread))
        self._weigh(log)

    def _weigh(self, log: Array) -> None:
        weights = np.exp((1.0 - _FORGETS) * (log - log.max())) * self._weights
        self._weights = np.maximum(weights / weights.sum(), 1e-6)


_EDGE_PX = 0.8
"""Standard deviation of each edge of a region: for optics and sampling."""
_EDGE_SHARE = 0.05
"""Standard deviation of the same by the region's own width and height: parts without contrast, limbs."""
_ALIKE = 3.0
"""Regions of successive pictures err alike (the same cold legs): so many count as one."""
_OUTLIER = 2.0
"""Deviations from which an edge counts less: feet behind a car, a head before a warm wall."""
_MIDDLE = np.array([[0.5, 0.0, 0.5, 0.0], [0.0, 0.5, 0.0, 0.5]])
_STILL_MPS, _RESTS, _AT_REST_MPS2 = 0.25, 4, 0.03
"""Speed below which a car or boat stands, after how many pictures it is taken to stay, and its acceleration then."""
_PARKS, _SETTLES = (CAR, BOAT), 15
_SURE = 0.5
"""Probability from which a region updates a track's heading and class."""
_MOVES = 2.0
"""Way of its middle in the picture, in longest sides of its rectangle, from which on a track has moved: what stands
comes from its parts and changes its size, by up to 1.3 of these in 70 minutes."""
_KIND_FORGETS = 0.95
_FOUND = (4.5, 0.5)
"""Beta prior of the share of pictures on which an object is found, and for how many pictures it is remembered."""
_FOUND_FORGETS = 0.9
_LEAST_FOUND = 0.3


@dataclass(eq=False)
class Mark:
    """One track.

    Attributes:
        identity: its number. afloat: whether on the water.
        state, covariance: (7,), (7, 7), see ``STATE``. log_odds: of its existence.
        log_kinds: (4,) log likelihoods of ``KINDS``. kind: the one whose sizes were its prior.
        heading: which way it points.
        seen_px: (4,) its last region. view: of the camera. missed_frames: pictures since then.
        still_frames: pictures in a row on which it stood still. has_moved: since it began, by ``_MOVES``.
        from_start: whether it began on one of the first pictures.
    """

    identity: int
    afloat: bool
    state: Array
    covariance: Array
    log_odds: float
    log_kinds: Array
    kind: Kind
    seen_px: Array
    view: SiteView
    heading: Heading = field(default_factory=Heading)
    missed_frames: int = 0
    still_frames: int = 0
    has_moved: bool = False
    from_start: bool = False
    expected_px: Array = field(default_factory=lambda: np.zeros(4))
    _jacobian: Array = field(default_factory=lambda: np.zeros((4, STATE)))
    _base_m: float = 0.0
    _found: Array = field(default_factory=lambda: np.array(_FOUND))
    _begun_px: Array | None = None

    @property
    def size_m(self) -> Array:
        """Length, width and height (3,)."""
        size: Array = np.exp(self.state[4:])
        return size

    @property
    def probability(self) -> float:
        """Of existence, of whatever class."""
        return float(1.0 / (1.0 + np.exp(-self.log_odds)))

    @property
    def intruder_probability(self) -> float:
        """Of existence as something else than a bird."""
        kinds = np.exp(self.log_kinds - self.log_kinds.max())
        return self.probability * float(1.0 - kinds[KINDS.index(BIRD)] / kinds.sum())

    @property
    def found_share(self) -> float:
        """Expected probability that a picture shows a region of it."""
        return max(_LEAST_FOUND, float(self._found[0] / self._found.sum()))

    @property
    def is_settled(self) -> bool:
        """Whether it is parked for long: it cools, and regions of its parts no longer show its class."""
        return self.kind in _PARKS and self.still_frames >= _SETTLES

    def predict(self, dt_s: float, survives: float) -> None:
        """Move by ``dt_s`` at constant velocity with white acceleration."""
        motion, pushed = np.eye(STATE), np.zeros((STATE, 2))
        motion[[0, 1], [2, 3]] = dt_s
        pushed[[0, 1], [0, 1]], pushed[[2, 3], [0, 1]] = 0.5 * dt_s**2, dt_s
        self.state = motion @ self.state
        is_parked = self.kind in _PARKS and self.still_frames >= _RESTS
        acceleration = _AT_REST_MPS2 if is_parked else self.kind.acceleration_mps2
        self.covariance = motion @ self.covariance @ motion.T + acceleration**2 * pushed @ pushed.T
        self.heading.turn()
        p = self.probability * survives
        self.log_odds = float(np.log(p / (1.0 - p)))

    def expect(self, base_m: float) -> None:
        """Work out the rectangle that is expected in the picture of an object that stands at ``base_m``.

        NaN behind the camera.
        """
        self._base_m = base_m
        box, jacobian = linearised(self.state, self.heading.likeliest_rad, base_m, self.kind.roof, self.view)
        sides = np.tile([self.view.camera.width_px, self.view.camera.height_px], 2)
        inside = (box > 0.0) & (box < sides)
        # The picture's border cuts the region off: that edge is no measurement.
        self.expected_px = np.clip(box, 0.0, sides)
        self._jacobian = jacobian * inside[:, None]

    def note_way(self) -> None:
        """Note whether the rectangle that is expected lies elsewhere than the first one."""
        middle, sides = _MIDDLE @ self.expected_px, self.expected_px[2:] - self.expected_px[:2]
        if self._begun_px is None:
            self._begun_px = middle
        self.has_moved |= bool(np.hypot(*(middle - self._begun_px)) > _MOVES * sides.max())

    def expected_middle(self) -> tuple[Array, Array]:
        """Return the expected middle (2,) of a region and its covariance (2, 2), pixels."""
        spread = _MIDDLE @ self._innovation(np.ones(4)) @ _MIDDLE.T
        return _MIDDLE @ self.expected_px, spread

    def middle_px(self) -> float:
        """Return the larger standard deviation of its middle in the picture, without a region's own noise."""
        side = _MIDDLE @ self._jacobian
        return float(np.sqrt(np.diag(side @ self.covariance @ side.T).max()))

    def _noise(self) -> Array:
        sides = self.expected_px[2:] - self.expected_px[:2]
        noise: Array = np.tile(_EDGE_PX**2 + (_EDGE_SHARE * sides) ** 2, 2)
        return noise

    def _innovation(self, doubt: Array) -> Array:
        spread: Array = self._jacobian @ self.covariance @ self._jacobian.T + np.diag(doubt * self._noise())
        return spread

    def correct(self, sighting: Sighting | None, hit: float) -> None:
        """Take in the sighting that is most likely of this track; ``hit``: probability that any one is."""
        self._found = _FOUND_FORGETS * self._found + (1.0 - _FOUND_FORGETS) * 5.0 * np.array([hit, 1.0 - hit])
        self.missed_frames += 1
        if sighting is None:
            self.still_frames = 0
            return
        self.heading.look(
            sighting.region.box_xyxy, self.state, self.covariance, self._base_m, self.kind.roof, self.view
        )
        self.expect(self._base_m)
        state, covariance = self._corrected(sighting)
        mean = hit * state + (1.0 - hit) * self.state
        mixed = [
            weight * (p + np.outer(x - mean, x - mean))
            for weight, x, p in ((hit, state, covariance), (1.0 - hit, self.state, self.covariance))
        ]
        self.state, self.covariance = mean, mixed[0] + mixed[1]
        is_still = float(np.hypot(*self.state[2:4])) < _STILL_MPS
        self.still_frames = self.still_frames + 1 if is_still else 0
        if hit > _SURE:
            self._recognise(sighting)

    def _corrected(self, sighting: Sighting) -> tuple[Array, Array]:
        """Return state and covariance after a region, by an extended Kalman filter with doubtful edges.

        The place takes a region as it is; sizes take it for a part of an independent one.
        """
        off = sighting.region.box_xyxy - self.expected_px
        deviations = np.abs(off) / np.sqrt(np.diag(self._innovation(np.ones(4))))
        doubt = np.maximum(1.0, deviations / _OUTLIER) ** 2
        across = self.covariance @ self._jacobian.T
        gain = np.linalg.solve(self._innovation(doubt), across.T).T
        gain[4:] = np.linalg.solve(self._innovation(doubt * _ALIKE), across[4:].T).T
        if self.is_settled:
            gain[4:] = 0.0
        elif self.kind is PERSON:
            # Arms and legs that swing hide the size of the body between them.
            gain[4:6] = 0.0
        kept = np.eye(STATE) - gain @ self._jacobian
        covariance = kept @ self.covariance @ kept.T + gain @ np.diag(doubt * self._noise()) @ gain.T
        return self.state + gain @ off, covariance

    def _recognise(self, sighting: Sighting) -> None:
        """Learn the class and the heading from the region that is most likely of this track."""
        self.seen_px, self.missed_frames = sighting.region.box_xyxy, 0
        if self.is_settled:
            return
        self.log_kinds = _KIND_FORGETS * self.log_kinds + sighting.log_kinds
        likeliest = KINDS[int(self.log_kinds.argmax())]
        if likeliest is not self.kind:
            self.kind = likeliest
            self.state[4:] = np.log(likeliest.size_m)
            self.covariance[4:], self.covariance[:, 4:] = 0.0, 0.0
            self.covariance[4:, 4:] = np.diag(likeliest.spread**2)
        self.heading.travel(self.state[2:4], self.covariance[2:4, 2:4])


def begun(identity: int, sighting: Sighting, probability: float, view: SiteView, base_m: float) -> Mark:
    """Begin a track at a sighting, with the sizes of its likeliest class."""
    kind = KINDS[int(sighting.log_kinds.argmax())]
    away = sighting.near_m - view.place_m[:2]
    away /= max(float(np.linalg.norm(away)), 1e-9)
    state = np.zeros(STATE)
    state[:2] = sighting.near_m + away * 0.25 * (kind.size_m[0] + kind.size_m[1])
    state[4:] = np.log(kind.size_m)
    covariance = np.zeros((STATE, STATE))
    # One pixel's rows cover metres of ground: the first place is as uncertain as two of them, and as the unknown depth.
    along = 4.0 * sighting.m2_per_px * view.camera.focal_px / float(np.linalg.norm(sighting.near_m - view.place_m[:2]))
    side = 0.5 * kind.size_m[1]
    spread = (along**2 + (0.25 * (kind.size_m[0] - kind.size_m[1])) ** 2 - side**2) * np.outer(away, away)
    covariance[:2, :2] = spread + side**2 * np.eye(2) if along > side else side**2 * np.eye(2)
    covariance[2:4, 2:4] = kind.speed_mps**2 * np.eye(2)
    covariance[4:, 4:] = np.diag(kind.spread**2)
    p = min(max(probability, 1e-9), 1.0 - 1e-9)
    log_odds = float(np.log(p / (1.0 - p)))
    box = sighting.region.box_xyxy
    mark = Mark(identity, sighting.afloat, state, covariance, log_odds, sighting.log_kinds.copy(), kind, box, view)
    mark.heading.look(box, state, covariance, base_m, kind.roof, view)
    return mark
