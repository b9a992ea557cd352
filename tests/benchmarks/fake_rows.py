"""Hand-made rows of a frame-out run: five trackers of known worth, eight seeds, three frame-outs each."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from benchmarks.contract.rows import Row
from benchmarks.run.result_folder import append_block

TRACKERS = {
    "sharp": ("ours", 0.95, 0.05),
    "blunt": ("variant", 0.8, 0.08),
    "colour_pf": ("as-written", 0.3, 0.6),
    "road_shape_pf": ("as-written", 0.7, 0.2),
    "hold": ("baseline", 0.15, 1.0),
    "oracle_map": ("oracle", 0.97, 0.04),
}
"""Name → role, chance to recover, metres of error gained a frame."""


def write_rows(directory: Path, seeds: range = range(10_000, 10_008)) -> None:
    """Write ``records.jsonl`` of all trackers on these seeds."""
    directory.mkdir(parents=True, exist_ok=True)
    for tracker in TRACKERS:
        for seed in seeds:
            append_block(directory, rows_of(tracker, seed))


def rows_of(tracker: str, seed: int) -> list[Row]:
    """Return the block of one tracker in one episode."""
    role, chance, drift_m = TRACKERS[tracker]
    # All trackers have the same frame-outs.
    lengths = np.random.default_rng(seed).integers(10, 120, 3)
    rng = np.random.default_rng([seed, list(TRACKERS).index(tracker)])
    heading = {
        "suite": "frame-out",
        "scenario": "road-town-v2",
        "preset": "standard",
        "tracker": tracker,
        "role": role,
        "controller": None,
        "renderer": "raster",
        "seed": seed,
        "repeat": 0,
    }
    rows: list[Row] = []

    def add(metric: str, value: object, weight: float = 1.0, frame_out: dict[str, object] | None = None) -> None:
        rest = {"metric": metric, "value": value, "weight": weight, "frame_out": frame_out, "seconds": 1.5}
        editions = {"numpy": "2.4.6", "scene": "road-town-v2 aa11", "tracker": f"{tracker} 1 bb22"}
        rows.append({**heading, **rest, "editions": editions})

    for index, length in enumerate(int(each) for each in lengths):
        exit_frame = 20 + 130 * index
        attributes: dict[str, object] = {
            "index": index,
            "exit_frame": exit_frame,
            "length_frames": length,
            "back_frame": exit_frame + length + 3,
            "kind": "excursion" if index == 2 else "road",
            "side": "left",
            "turned": index == 1,
            "long": length > 100,
        }
        found = bool(rng.random() < chance)
        error = drift_m * (1 + np.arange(length)) * rng.lognormal(0, 0.3, length)
        add("recovered", float(found), frame_out=attributes)
        add("kept", float(found), frame_out=attributes)
        add("recovery_frames", float(rng.integers(0, 5)) if found else None, frame_out=attributes)
        add("watched_frames", 40.0, frame_out=attributes)
        add("offscreen_error_by_frame_m", error.round(3).tolist(), frame_out=attributes)
        if length > 30:
            add("offscreen_error_30_m", float(error[30]), frame_out=attributes)
    if role != "baseline":
        levels = rng.dirichlet(np.full(20, 20.0) if role != "as-written" else np.geomspace(40, 2, 20))
        add("credible_level_histogram", levels.round(4).tolist(), weight=float(lengths.sum()))
        add("coverage_95", float(levels[:19].sum()), weight=float(lengths.sum()))
    add("in_view_tpr", 0.99 if role == "ours" else 0.8, weight=200)
    add("in_view_tnr", 0.97 if role == "ours" else 0.5, weight=200)
    add("frames_per_s", float(rng.uniform(60, 160)))
    add("frames", 400.0)
    return [json.loads(json.dumps(row)) for row in rows]
