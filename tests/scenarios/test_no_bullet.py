"""Nothing asks for PyBullet but its own renderer and ``sim.bullet``: all runs where it cannot be imported."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

BLOCKED = "import sys; sys.modules['pybullet'] = None\n"
"""Importing it raises ImportError from now on."""
SCENES = """
from dataclasses import replace
from scenarios import catalog
for name in ("road-town", "stereo-follow", "fish-tank", "harbour"):
    scene = catalog.scenario(name)
    preset = replace(scene.presets["quick"], width_px=80, height_px=60)
    frame = scene.episode(preset, 3, closed_loop=False).step()
    assert frame.truth.instance_map.shape == (60, 80)
"""
ENV = """
import gc, weakref
import gymnasium as gym
changes = {"width_px": 84, "height_px": 84}
worlds = weakref.WeakSet()
for seed in range(2):
    env = gym.make("scenarios:frameout/RoadTownFollow-v3", preset="quick", tracker="hold", changes=changes)
    env.reset(seed=seed)
    worlds.add(env.unwrapped.episode.episode.world)
    env = None
    gc.collect()
assert len(worlds) == 0, "an env that is dropped without close() keeps its world"
"""
BENCH = """
from benchmarks.cli import main as cli
sys.argv = ["frameout", "bench", "frame-out", "--quick", "--seeds", "0:1", "--out", "bench"]
assert cli.main() == 0
"""
GENERATE = """
from benchmarks.cli import main as cli
sys.argv = ["frameout", "generate", "fish-tank", "--preset", "quick", "--seeds", "0:1", "--out", "data"]
assert cli.main() == 0
"""


def run(program: str, folder: Path) -> None:
    path = str(Path(__file__).parents[2])
    code = f"import sys; sys.path.insert(0, {path!r})\n{program}"
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.heavy
@pytest.mark.parametrize("program", [SCENES, ENV])
def test_all_scenes_and_an_env_run_without_pybullet(program: str, tmp_path: Path) -> None:
    run(BLOCKED + program, tmp_path)


@pytest.mark.heavy
def test_an_env_imports_no_pybullet_where_there_is_one(tmp_path: Path) -> None:
    run(ENV + "import sys; assert 'pybullet' not in sys.modules", tmp_path)


@pytest.mark.heavy
@pytest.mark.parametrize("program", [BENCH, GENERATE])
def test_commands_import_no_pybullet_in_any_process(program: str, tmp_path: Path) -> None:
    """Workers are other processes, so that an import in one would fail there."""
    (tmp_path / "pybullet.py").write_text("raise ImportError('pybullet was imported')\n")
    run(
        f"import os; os.environ['PYTHONPATH'] = {str(tmp_path)!r} + ':' + {str(Path(__file__).parents[2])!r}\n"
        f"sys.path.insert(0, {str(tmp_path)!r})\n{program}\nassert 'pybullet' not in sys.modules",
        tmp_path,
    )
