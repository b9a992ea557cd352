"""Records TrackEval's results on random tracks in ``trackeval.json``, which tests compare ours with.

TrackEval is not a dependency, since it needs another OpenCV. In an environment of its own, from the root of a checkout:

    pip install --no-deps trackeval==1.3.0 && pip install "numpy>=2.3.2" scipy
    python tests/benchmarks/judges/record_trackeval.py
"""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FILE = Path(__file__).with_name("trackeval.json")
ZERO_PX = 30.0
_COMMAND = "python tests/benchmarks/judges/record_trackeval.py"

Placed = list[list[list[float]]]
"""On each frame the identity, x and y of each target or track."""


def random_tracks(seed: int, targets: int, frames: int, noise_px: float, lost: float, swapped: float) -> Any:
    """Return targets on random walks and tracks on them, with misses, swaps, false tracks and empty frames."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(0, 120, (targets, 2))
    names = np.arange(targets) * 3 + 1
    truth: Placed = []
    tracks: Placed = []
    for _ in range(frames):
        place = place + rng.normal(0, 3.0, place.shape)
        if rng.random() < swapped and targets > 1:
            a, b = rng.choice(targets, 2, replace=False)
            names[[a, b]] = names[[b, a]]
        if rng.random() < swapped:
            names[rng.integers(targets)] = names.max() + 2
        there, said = rng.random(targets) > 0.1, rng.random(targets) > lost
        if rng.random() < 0.05:
            there[:] = False
        if rng.random() < 0.05:
            said[:] = False
        seen = place + rng.normal(0, noise_px, place.shape)
        truth.append(_listed(np.arange(targets)[there], place[there]))
        false = [[1000 + int(rng.integers(3)), *np.round(rng.uniform(0, 120, 2), 2).tolist()]] * (rng.random() < 0.2)
        tracks.append(_listed(names[said], seen[said]) + false)
    return {"targets": truth, "tracks": tracks}


def _listed(names: NDArray[np.int64], places: NDArray[np.float64]) -> list[list[float]]:
    return [[int(name), *np.round(place, 2).tolist()] for name, place in zip(names, places, strict=True)]


def sequences() -> dict[str, Any]:
    """Return the recorded sequences by name."""
    return {
        "good": random_tracks(1, 6, 60, 2.0, 0.05, 0.02),
        "many swaps": random_tracks(2, 5, 60, 4.0, 0.1, 0.3),
        "noisy": random_tracks(3, 8, 40, 14.0, 0.2, 0.1),
        "one target": random_tracks(4, 1, 50, 3.0, 0.3, 0.1),
        "no track": {**random_tracks(5, 4, 10, 1.0, 0.0, 0.0), "tracks": [[]] * 10},
        "no target": {**random_tracks(6, 4, 10, 1.0, 0.0, 0.0), "targets": [[]] * 10},
        "crowd": random_tracks(7, 30, 30, 6.0, 0.15, 0.3),
    }


def _result(sequence: Any) -> dict[str, float]:
    import trackeval

    known = [sorted({int(one[0]) for frame in sequence[side] for one in frame}) for side in ("targets", "tracks")]
    ids = [
        [np.array([names.index(one[0]) for one in frame], int) for frame in sequence[side]]
        for side, names in zip(("targets", "tracks"), known, strict=True)
    ]
    places = [
        [np.array([one[1:] for one in frame], float).reshape(-1, 2) for frame in sequence[side]]
        for side in ("targets", "tracks")
    ]
    similarity = trackeval.datasets._base_dataset._BaseDataset._calculate_euclidean_similarity
    data = {
        "gt_ids": ids[0],
        "tracker_ids": ids[1],
        "similarity_scores": [similarity(a, b, zero_distance=ZERO_PX) for a, b in zip(*places, strict=True)],
        "num_gt_dets": sum(map(len, ids[0])),
        "num_tracker_dets": sum(map(len, ids[1])),
        "num_gt_ids": len(known[0]),
        "num_tracker_ids": len(known[1]),
        "num_timesteps": len(ids[0]),
    }
    quiet = {"PRINT_CONFIG": False}
    h = trackeval.metrics.HOTA().eval_sequence(data)
    i = trackeval.metrics.Identity(quiet).eval_sequence(data)
    c = trackeval.metrics.CLEAR(quiet).eval_sequence(data)
    counts = {name: int(i[name]) for name in ("IDTP", "IDFN", "IDFP")}
    counts |= {name: int(c[name]) for name in ("CLR_TP", "CLR_FN", "CLR_FP", "IDSW")}
    return counts | {"HOTA": float(np.mean(h["HOTA"])), "IDF1": float(i["IDF1"]), "MOTA": float(c["MOTA"])}


def main() -> None:
    """Write the file."""
    entries = {name: {**sequence, "result": _result(sequence)} for name, sequence in sequences().items()}
    recorded = {"command": _COMMAND, "trackeval": version("trackeval"), "zero_px": ZERO_PX, "sequences": entries}
    FILE.write_text(json.dumps(recorded, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
