"""First, plain version, so that episodes can be lived through; the town helper replaces it."""

from __future__ import annotations

import numpy as np
from scenarios.road_town.layout import Building, Layout, Tree


def fill_blocks(graph, rng, extent_m):
    from scenarios.road_town.road_map import RoadMap

    rm = RoadMap(graph)
    B = []
    T = []
    while len(B) < 110:
        c = rng.uniform(-0.47 * extent_m, 0.47 * extent_m, 2)
        n = rm.nearest(c[None])
        s = rng.uniform([9, 8, 4], [18, 12, 10])
        d = abs(n.lateral_m[0])
        if d < 5 + 0.6 * s[0] or any(
            np.hypot(*(c - np.array(b.centre_m))) < 0.75 * (s[0] + b.size_m[0]) - 2 for b in B
        ):
            if rng.random() < 0.01:
                break
            continue
        B.append(
            Building(
                tuple(c),
                tuple(s),
                float(rng.uniform(0, 3)),
                ["gable", "hip", "flat"][int(rng.integers(3))],
                (200, 190, 170),
                (150, 70, 60),
            )
        )
    while len(T) < 100:
        c = rng.uniform(-0.47 * extent_m, 0.47 * extent_m, 2)
        if abs(rm.nearest(c[None]).lateral_m[0]) < 6.5 or any(
            np.hypot(*(c - np.array(b.centre_m))) < b.size_m[0] * 0.7 + 1 for b in B
        ):
            continue
        T.append(Tree(tuple(c), float(rng.uniform(1.5, 3.5)), float(rng.uniform(4, 9))))
    return Layout(extent_m, graph, tuple(B), tuple(T), ())
