"""Records Stone Soup's GOSPA on random points in ``stone_soup.json``, which tests compare ours with.

Stone Soup is not a dependency. In an environment of its own, from the root of a checkout:

    pip install stonesoup==1.9.1
    python tests/benchmarks/judges/record_stone_soup.py
"""

from __future__ import annotations

import json
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FILE = Path(__file__).with_name("stone_soup.json")
_COMMAND = "python tests/benchmarks/judges/record_stone_soup.py"


def frames() -> list[dict[str, Any]]:
    """Return frames of targets and tracks on a plane, with the cut-off and the order of each."""
    made = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        targets = rng.uniform(0, 10, (rng.integers(0, 7), 2))
        near = targets[rng.random(len(targets)) > rng.choice([0.3, 1.0])] + rng.normal(0, 1.5, 2)
        tracks = np.concatenate([near, rng.uniform(0, 10, (rng.integers(0, 5), 2))])
        how = {"cutoff": float(rng.choice([1.0, 3.0, 8.0])), "order": float(rng.choice([1.0, 2.0]))}
        if len(targets) + len(tracks) > 0:  # Stone Soup refuses a frame without either.
            made.append({**how, "targets": np.round(targets, 3).tolist(), "tracks": np.round(tracks, 3).tolist()})
    return made


def _gospa(frame: dict[str, Any]) -> float:
    from stonesoup.metricgenerator.ospametric import GOSPAMetric
    from stonesoup.types.state import State

    def states(places: list[list[float]]) -> list[State]:
        return [State(np.array(place)[:, None], datetime(2020, 1, 1)) for place in places]

    metric = GOSPAMetric(c=frame["cutoff"], p=frame["order"])
    found, _ = metric.compute_gospa_metric(states(frame["tracks"]), states(frame["targets"]))
    return float(found.value["distance"])


def distances(frame: dict[str, Any]) -> NDArray[np.float64]:
    """Return the distances (n, m) of a frame's targets to its tracks."""
    targets, tracks = (np.array(frame[name], float).reshape(-1, 2) for name in ("targets", "tracks"))
    return np.linalg.norm(targets[:, None] - tracks[None], axis=2)


if __name__ == "__main__":
    recorded = [{**frame, "gospa": _gospa(frame)} for frame in frames()]
    FILE.write_text(json.dumps({"command": _COMMAND, "stonesoup": version("stonesoup"), "frames": recorded}) + "\n")
