"""Sets of particles on a stack, each of which detects or tracks one object (paper D, section 3)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackers.eigen_swarm.particles import cloud, count_inside, likelihoods, move
from trackers.kernels.resampling import systematic_indices
from trackers.registry import tunable
from trackers.site.volume import PlacedVolume

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
    asked = p.uses_direction or p.uses_distance
    return asked and (aligned or not p.uses_direction) and (near or not p.uses_distance)


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
