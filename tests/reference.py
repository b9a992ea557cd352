"""Hashes of pictures and truth, scores, and policies' actions: what a rebuilding must leave as it is.

    python -m tests.reference write FILE.json
    python -m tests.reference compare FILE.json

The second prints every difference, and exits with 1 if there is one. Bits hold on one architecture alone, so this is a
script and no test: write on the commit before, compare on the one after, on one machine.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from benchmarks.cli.main import main as frameout
from benchmarks.judges.tracker_speed import TIMES
from scenarios import catalog
from scenarios.truth import Truth
from trackers.types import CameraCommand

_SEED = 3
_FRAMES = 12
_LATER = ("band", "counts", "steered")
"""Fields that lists written before they came do not have; left out where they say what was so without them."""
_BENCHES = (
    "frame-out --preset quick --seeds 0:2",
    "frame-out --preset paper-a2 --seeds 0:1 --trackers colour_pf road_shape_pf hold",
    "stereo --preset quick --seeds 0:1",
    "follow --preset quick --seeds 0:1 --scenario road-town --trackers colour_pf"
    " --controllers hold centre search reentry",
    "follow --preset quick --seeds 0:1 --scenario stereo-follow --trackers stereo_people"
    " --controllers hold centre search reentry",
)
_ENVS = ("frameout/RoadTownFollow-v3", "frameout/StereoFollow-v3")


def reference() -> dict[str, Any]:
    """Return key -> hash or value."""
    return dict([*_pictures(), *_pictureless(), *_scores()])


def _pictures() -> Iterator[tuple[str, str]]:
    for name in catalog.names():
        scenario = catalog.scenario(name)
        for preset in scenario.presets:
            for looped in (False, True):
                try:
                    episode = scenario.episode(preset, _SEED, closed_loop=looped, truth="target" if looped else "all")
                except ValueError:
                    # A sheet of paper is not steered after.
                    continue
                command = CameraCommand(forward_mps=0.7, right_mps=0.3, yaw_rate_rad_s=0.05) if looped else None
                for k in range(min(_FRAMES, episode.frame_count)):
                    frame = episode.step(command if k > 0 else None)
                    of = f"{name} {preset} {'steered' if looped else 'set path'} {k}"
                    for field, value in _fields(frame.observation):
                        yield f"{of} observation.{field}", value
                    for field, value in _told(frame.truth, frame.truth.index_of(scenario.target)):
                        yield f"{of} truth.{field}", value
                episode.close()


def _told(truth: Truth, target: int) -> Iterator[tuple[str, str]]:
    """Yield the fields of truth as they were when the target was its business, and its state alone was told."""
    since = int(truth.frames_since_exit[target])
    once = {"state": str(truth.state[target]), "side": str(truth.side[target]) or None, "frames_since_exit": since}
    yield "target", _hash(target)
    yield from (dict(_fields(truth)) | {field: _hash(value) for field, value in once.items()}).items()


def _fields(value: Any) -> Iterator[tuple[str, str]]:
    for field in dataclasses.fields(value):
        held = getattr(value, field.name)
        if field.name not in _LATER or held != field.default:
            yield field.name, _hash(held)


def _hash(value: Any) -> str:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return _hash(list(_fields(value)))
    if isinstance(value, np.ndarray):
        told = f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes()
        return hashlib.sha256(told).hexdigest()[:12]
    return hashlib.sha256(repr(value).encode()).hexdigest()[:12]


def _pictureless() -> Iterator[tuple[str, str]]:
    for name in _ENVS:
        env = gym.make_vec(f"scenarios:{name}", num_envs=4, pictures=False)
        rng = np.random.default_rng(7)
        observed, _ = env.reset(seed=5)
        for k in range(100):
            yield f"{name} without pictures {k}", _hash(np.asarray(observed))
            action = rng.uniform(-1, 1, env.action_space.shape).astype(np.float32)
            observed, reward, *_ = env.step(action)
            yield f"{name} without pictures {k} reward", _hash(np.asarray(reward))
        env.close()


def _scores() -> Iterator[tuple[str, Any]]:
    for k, words in enumerate(_BENCHES):
        with tempfile.TemporaryDirectory() as folder:
            assert frameout(["bench", *words.split(), "--out", folder]) == 0
            lines = (Path(folder) / "records.jsonl").read_text().splitlines()
        for row in map(json.loads, lines):
            if row["metric"] in TIMES:
                continue
            event = row.get("frame_out") or row.get("event")
            about = "" if event is None else json.dumps(event)
            who = f"{row['suite']} {row['scenario']} {row['preset']} {row['tracker']} {row['controller']} {row['seed']}"
            value = [row["value"], row["weight"]]
            yield f"{k} {who} {row['metric']} {row['repeat']} {about}", value


def main(words: list[str]) -> int:
    """Write or compare; return the exit status."""
    mode, file = words
    found = json.loads(json.dumps(reference()))
    if mode == "write":
        Path(file).write_text(json.dumps(found, indent=0, sort_keys=True) + "\n")
        print(f"{len(found)} hashes and scores")
        return 0
    before = json.loads(Path(file).read_text())
    different = [key for key in sorted({*before, *found}) if before.get(key) != found.get(key)]
    for key in different:
        print(f"{key}: {json.dumps(before.get(key))[:80]} -> {json.dumps(found.get(key))[:80]}")
    print(f"{len(found)} hashes and scores, {len(different)} differences")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
