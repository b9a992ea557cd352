"""How often solid bodies of a scene stand in one another, counted by Bullet's closest points.

``python -m tests.scenarios.standing_in_one_another SCENE PRESET`` prints the share of sampled instants (20 development
seeds, 6 instants each) at which two different things that move stand deeper in one another than 2 cm. Things are taken
by the convex hulls of their parts; ropes and the sea are not counted.
"""

from __future__ import annotations

import sys
from collections import Counter
from itertools import combinations
from typing import Any

import numpy as np

from scenarios import catalog
from sim import bullet

SEEDS, INSTANTS, DEEPER_M = range(20), 6, 0.02
_AWAY_BELOW_M = -100.0
"""Scenes put bodies that are not in the world far below it."""
_LEFT_OUT = ("sea", "rope")


def thing_of(name: str) -> str:
    """Return whose part a body is: ``target left_foot`` is of ``target``."""
    return name.rsplit(" ", 1)[0]


def pairs_in_one_another(client: bullet.Client, world: Any) -> dict[tuple[str, str], float]:
    """Return the depth in metres at which pairs of things stand in one another now, by their names."""
    client.push()
    present = world.poses[:, 2, 3] > _AWAY_BELOW_M
    movers = [b for b in world.bodies if b.movable and present[b.index] and b.category not in _LEFT_OUT]
    low, high = [], []
    for body in movers:
        T = world.poses[body.index]
        points_m = body.mesh.vertices_m @ T[:3, :3].T + T[:3, 3]
        low.append(points_m.min(axis=0))
        high.append(points_m.max(axis=0))
    found: dict[tuple[str, str], float] = {}
    for (a, one), (b, other) in combinations(enumerate(movers), 2):
        whose = thing_of(one.name), thing_of(other.name)
        if whose[0] == whose[1] or (low[a] > high[b]).any() or (low[b] > high[a]).any():
            continue
        points = client.engine.getClosestPoints(client.handles[one.index], client.handles[other.index], 0.0)
        depth_m = -min((point[8] for point in points), default=0.0)
        if depth_m > DEEPER_M:
            found[whose] = max(depth_m, found.get(whose, 0.0))
    return found


def count(scenario: str, preset: str, seeds: range = SEEDS) -> tuple[int, int, float, Counter[str]]:
    """Return the instants, those with such a pair, the greatest depth in metres, and how often each kind of pair."""
    scene = catalog.scenario(scenario)
    instants = hit = 0
    deepest_m, kinds = 0.0, Counter[str]()
    for seed in seeds:
        episode: Any = scene.episode(preset, seed, closed_loop=False)
        with bullet.client(episode.world) as client:
            for frame in np.linspace(0, episode.frame_count - 1, INSTANTS).astype(int).tolist():
                episode._move_to(frame)
                found = pairs_in_one_another(client, episode.world)
                instants += 1
                hit += bool(found)
                deepest_m = max(deepest_m, *found.values(), 0.0)
                kinds.update(" and ".join(sorted(name.rstrip("-0123456789") for name in pair)) for pair in found)
    return instants, hit, deepest_m, kinds


if __name__ == "__main__":
    for name in sys.argv[2:]:
        total, with_pair, deep_m, what = count(sys.argv[1], name)
        kinds = ", ".join(f"{pair} {times}" for pair, times in what.most_common())
        print(f"{sys.argv[1]} {name}: {with_pair} of {total} instants, at most {deep_m:.2f} m; {kinds}", flush=True)
