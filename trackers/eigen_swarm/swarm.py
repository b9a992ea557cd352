"""Sets of particles on a stack, each of which detects or tracks one object (paper D, section 3)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.kernels.particles import systematic_indices
from trackers.registry import tunable
from trackers.site import PlacedVolume


@njit(cache=True)
def move(
    states: NDArray[np.float64],
    noise: NDArray[np.float64],
    interval_s: float,
    place_noise_m: float,
    velocity_noise_mps: float,
) -> None:
    """Equation (3) in place: ``x_t = F x_{t−1} + W``, ``F`` moves each place on by its velocity.

    Args:
        states: (N, 6) x, y, z in metres, their velocities in m/s. noise: (N, 6) standard normal.
        place_noise_m, velocity_noise_mps: standard deviations of W.
    """
    for i in range(len(states)):
        for axis in range(3):
            states[i, axis] += interval_s * states[i, 3 + axis] + place_noise_m * noise[i, axis]
            states[i, 3 + axis] += velocity_noise_mps * noise[i, 3 + axis]


@njit(cache=True)
def likelihoods(
    states: NDArray[np.float64],
    P_block_world: NDArray[np.float64],
    f: NDArray[np.float64],
    centre_m: NDArray[np.float64],
    axes: NDArray[np.float64],
    half_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The likelihood of each particle, section 2.2: f of the block into which the camera projects it.

    ``(a, b, c) = P (x, y, z, 1)``; block row ``floor(b / c)``, column ``floor(a / c)``. It is 0 outside the watched
    volume, outside the picture and behind the camera, where nothing is seen.

    Args:
        states: (N, 6). P_block_world: (3, 4), from metres to blocks.
        f: (rows, columns), equation (2).
        centre_m: (3,), axes: (3, 3) rows, half_m: (3,) half the extents of the watched volume.

    Returns:
        (N,).
    """
    rows, columns = f.shape
    result = np.zeros(len(states))
    for i in range(len(states)):
        x, y, z = states[i, 0], states[i, 1], states[i, 2]
        inside = True
        for axis in range(3):
            offset = axes[axis, 0] * (x - centre_m[0]) + axes[axis, 1] * (y - centre_m[1])
            offset += axes[axis, 2] * (z - centre_m[2])
            inside = inside and abs(offset) <= half_m[axis]
        c = P_block_world[2, 0] * x + P_block_world[2, 1] * y + P_block_world[2, 2] * z + P_block_world[2, 3]
        if not inside or c <= 0.0:
            continue
        a = P_block_world[0, 0] * x + P_block_world[0, 1] * y + P_block_world[0, 2] * z + P_block_world[0, 3]
        b = P_block_world[1, 0] * x + P_block_world[1, 1] * y + P_block_world[1, 2] * z + P_block_world[1, 3]
        if 0.0 <= a < columns * c and 0.0 <= b < rows * c:
            result[i] = f[min(int(b / c), rows - 1), min(int(a / c), columns - 1)]
    return result


@njit(cache=True)
def cloud(
    states: NDArray[np.float64], likelihood: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Centre, direction and spread of a cloud, section 3.1.

    ``x_0 = Σ π_i x_i / Σ π_i`` (equations (4), (5)), y_0 and z_0 alike. PCA of the places in the XY plane about the
    centre: ``a_1`` is the direction of the greatest variance ``sigma_1²``, ``a_2`` lies across. ``sigma_z`` likewise.

    Args:
        states: (N, 6) resampled particles. likelihood: (N,) π, not all zero.

    Returns:
        centre (3,); a_1 (2,) of length 1; (sigma_1, sigma_2, sigma_z).
    """
    count = len(states)
    centre = np.zeros(3)
    total = 0.0
    for i in range(count):
        total += likelihood[i]
        for axis in range(3):
            centre[axis] += likelihood[i] * states[i, axis]
    centre /= total
    xx, xy, yy, zz = 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        x, y, z = states[i, 0] - centre[0], states[i, 1] - centre[1], states[i, 2] - centre[2]
        xx += x * x
        xy += x * y
        yy += y * y
        zz += z * z
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    c, s = np.cos(angle), np.sin(angle)
    along = c * c * xx + 2.0 * c * s * xy + s * s * yy
    across = s * s * xx - 2.0 * c * s * xy + c * c * yy
    spread = np.sqrt(np.maximum(np.array([along, across, zz]) / count, 0.0))
    return centre, np.array([c, s]), spread


@njit(cache=True)
def count_inside(
    states: NDArray[np.float64], centre: NDArray[np.float64], a1: NDArray[np.float64], half_m: NDArray[np.float64]
) -> int:
    """N_in of equation (6): the particles inside the region, an upright box with one side along a_1.

    Args:
        states: (N, 6). centre: (3,). a1: (2,).
        half_m: (3,) half of the region's depth, width and height.
    """
    inside = 0
    for i in range(len(states)):
        x, y, z = states[i, 0] - centre[0], states[i, 1] - centre[1], states[i, 2] - centre[2]
        along, across = a1[0] * x + a1[1] * y, a1[0] * y - a1[1] * x
        inside += abs(along) <= half_m[0] and abs(across) <= half_m[1] and abs(z) <= half_m[2]
    return inside


_LEAST_SPREAD_M = 0.01
"""A cloud whose particles all descend from one has no extent, and then no density either."""


@dataclass(frozen=True)
class SwarmParameters:
    """Parameters of the particle sets; the values that are not tunable are those of section 4.1.

    The paper is silent on those that are tunable. They were chosen on development seeds.

    Attributes:
        particles: of each set.
        depth_share: ε, the region's depth as a share of the cloud's.
        density_in, density_out: alpha_in and alpha_out, particles per cubic metre.
        direction_threshold: v_th, the cosine of the greatest angle between duplicates.
        start_speed_mps: standard deviation of each horizontal velocity of a set that was scattered.
        place_noise_m, velocity_noise_mps: standard deviations of W, a picture.
        patience_pictures: after which a set that still detects is scattered anew.
        most_sets: that may lie on the stack. The paper sets no limit, and then a picture may take any time.
        uses_direction, uses_distance: whether a duplicate must satisfy (7), and (8); with neither none is removed.
    """

    particles: int = 4000
    depth_share: float = 0.1
    density_in: float = 0.1
    density_out: float = 0.2
    direction_threshold: float = 0.9996
    start_speed_mps: float = tunable(1.8, 0.05, 8.0, log=True)
    place_noise_m: float = tunable(0.35, 0.05, 3.0, log=True)
    velocity_noise_mps: float = tunable(0.3, 0.02, 2.0, log=True)
    patience_pictures: int = tunable(6, 1, 30)
    most_sets: int = 40
    uses_direction: bool = True
    uses_distance: bool = True


@dataclass(frozen=True, eq=False)
class Region:
    """The region of an object, section 3.1.

    Attributes:
        centre_m: (3,) in the world.
        a1: (2,) direction of the greatest variance in the XY plane.
        spread_m: (3,) sigma_1, sigma_2, sigma_z.
        size_m: (3,) depth ``2 sigma_1 ε``, width ``2 sigma_2``, height ``2 sigma_z``.
        density: rho of equation (6), particles per cubic metre.
    """

    centre_m: NDArray[np.float64]
    a1: NDArray[np.float64]
    spread_m: NDArray[np.float64]
    size_m: NDArray[np.float64]
    density: float


@dataclass(eq=False)
class ParticleSet:
    """One set.

    Attributes:
        number: its own, given once.
        states: (N, 6) particles of equal weight.
        tracks: True in the state *tracking*, False in *detecting*.
        pictures: since it was scattered.
        region: after the latest resampling; None if no particle was seen in the picture then.
        mean_likelihood: of its particles before that.
    """

    number: int
    states: NDArray[np.float64]
    tracks: bool = False
    pictures: int = 0
    region: Region | None = field(default=None, repr=False)
    mean_likelihood: float = 0.0


class Swarm:
    """The stack.

    Attributes:
        stack: the sets from bottom to top. The last one detects, unless the stack is full.
    """

    def __init__(
        self,
        parameters: SwarmParameters,
        volume: PlacedVolume,
        P_block_world: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> None:
        """``P_block_world``: (3, 4) projection from metres to blocks of the picture."""
        self._parameters, self._volume, self._rng = parameters, volume, rng
        self._P_block_world = P_block_world
        self._numbers = 0
        self.stack: list[ParticleSet] = []
        self._place_detecting_set()

    def step(self, f: NDArray[np.float64], interval_s: float) -> list[ParticleSet]:
        """Take in the likelihoods f (rows, columns) of a picture and return the sets that track, oldest first.

        ``interval_s``: since the picture before. A set that was only just placed does not move.
        """
        for each in self.stack:
            if each.pictures > 0:
                self._predict(each, interval_s)
            self._observe(each, f)
        self._change_states()
        self._remove_duplicates()
        if all(each.tracks for each in self.stack) and len(self.stack) < self._parameters.most_sets:
            self._place_detecting_set()
        return [each for each in self.stack if each.tracks]

    def _place_detecting_set(self) -> None:
        self.stack.append(ParticleSet(self._numbers, self._scattered()))
        self._numbers += 1

    def _scattered(self) -> NDArray[np.float64]:
        """Return states (N, 6), uniform over the watched volume."""
        count = self._parameters.particles
        velocities_mps = self._rng.normal(0.0, [self._parameters.start_speed_mps] * 2 + [0.0], (count, 3))
        return np.hstack([self._volume.scatter(self._rng, count), velocities_mps])

    def _predict(self, each: ParticleSet, interval_s: float) -> None:
        p = self._parameters
        noise = self._rng.standard_normal(each.states.shape)
        move(each.states, noise, interval_s, p.place_noise_m, p.velocity_noise_mps)

    def _observe(self, each: ParticleSet, f: NDArray[np.float64]) -> None:
        volume = self._volume
        weights = likelihoods(each.states, self._P_block_world, f, volume.centre_m, volume.axes, 0.5 * volume.size_m)
        each.pictures += 1
        each.mean_likelihood = float(weights.mean())
        if each.mean_likelihood > 0.0:
            ancestors = systematic_indices(weights, self._rng.random())
            each.states = each.states[ancestors]
            each.region = region_of(each.states, weights[ancestors], self._parameters.depth_share)
        else:
            each.region = None

    def _change_states(self) -> None:
        """A dense set tracks; one that tracks and thins is removed; one that detects too long is scattered anew."""
        p = self._parameters
        kept = []
        for each in self.stack:
            density = 0.0 if each.region is None else each.region.density
            if each.tracks and density < p.density_out:
                continue
            if not each.tracks and density > p.density_in:
                each.tracks = True
            elif not each.tracks and each.pictures >= p.patience_pictures:
                each.states, each.pictures = self._scattered(), 0
            kept.append(each)
        self.stack = kept

    def _remove_duplicates(self) -> None:
        """Remove sets that track what an older one, lower on the stack, tracks already."""
        kept: list[ParticleSet] = []
        for each in self.stack:
            older = [other.region for other in kept if other.tracks and other.region is not None]
            found = each.region if each.tracks else None
            if found is None or not any(is_duplicate(found, m, self._parameters) for m in older):
                kept.append(each)
        self.stack = kept


def is_duplicate(n: Region, m: Region, parameters: SwarmParameters) -> bool:
    """Return whether a region n has the direction of an older region m and lies as near to it.

    (7) ``|a_1ⁿ · a_1ᵐ| > v_th`` and (8) ``L < sigma_2ᵐ + sigma_2ⁿ``. Readings: eigenvectors have no sign,
    and L is the distance of the centres in the XY plane.
    """
    p = parameters
    aligned = abs(float(n.a1 @ m.a1)) > p.direction_threshold
    near = float(np.hypot(*(n.centre_m - m.centre_m)[:2])) < n.spread_m[1] + m.spread_m[1]
    tested = p.uses_direction or p.uses_distance
    return tested and (aligned or not p.uses_direction) and (near or not p.uses_distance)


def region_of(states: NDArray[np.float64], likelihood: NDArray[np.float64], depth_share: float) -> Region:
    """Return the region of resampled particles (N, 6) with their likelihoods (N,), not all zero.

    Size: ``2 sigma_1 ε``, ``2 sigma_2``, ``2 sigma_z``. Density (6), without ε in the denominator:
    ``rho = N_in / (2 sigma_1 · 2 sigma_2 · 2 sigma_z)``.
    """
    centre_m, a1, spread_m = cloud(states, likelihood)
    spread_m = np.maximum(spread_m, _LEAST_SPREAD_M)
    size_m = 2.0 * spread_m * np.array([depth_share, 1.0, 1.0])
    inside = count_inside(states, centre_m, a1, 0.5 * size_m)
    return Region(centre_m, a1, spread_m, size_m, inside / float(np.prod(2.0 * spread_m)))
