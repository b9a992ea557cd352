"""Kernels give the same bits in the process that compiles them as in those that read them from disk."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

FRAMES = """
import dataclasses, hashlib, sys
import numpy as np
from scenarios import catalog

episode = catalog.scenario(sys.argv[1]).episode(sys.argv[2], 0)
digest = hashlib.sha256()
for _ in range(2):
    frame = episode.step()
    for part in (frame.observation, frame.truth):
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            if isinstance(value, np.ndarray | float):
                digest.update(np.ascontiguousarray(value).tobytes() if np.asarray(value).dtype.kind != "U" else b"")
print(digest.hexdigest())
"""
PRESETS = (
    ("road-town", "quick[weather=rain,sun_elevation_deg=-8,smooth_edges=true]"),
    ("fish-tank", "quick"),
    ("stereo-follow", "quick"),
    ("harbour", "quick"),
)


@pytest.mark.heavy
@pytest.mark.parametrize(("scenario", "preset"), PRESETS, ids=[name for name, _ in PRESETS])
def test_frames_are_the_same_with_cold_and_with_warm_kernels(scenario, preset, tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", FRAMES, scenario, preset]
    cold, warm = (subprocess.run(command, env=environment, check=True, capture_output=True).stdout for _ in range(2))
    assert any(tmp_path.rglob("*.nbc"))
    assert cold == warm
