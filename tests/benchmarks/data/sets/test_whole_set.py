"""A set of three scenes in three weathers with one's own mesh, from one file: made in one go, killed and continued,
and made by jobs, with the same bytes; each export is read by its own reader, and truth against itself is perfect.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
from trimesh.transformations import translation_matrix

from benchmarks.cli.data_functions import export, merge, verify
from benchmarks.data.exports.exporter import formats
from benchmarks.data.sets.data_set import DataSet
from tests.benchmarks.data.exports.own_readers import READERS
from tests.benchmarks.data.sets.test_generating import digests

pytestmark = [
    pytest.mark.heavy,
    pytest.mark.filterwarnings("ignore:__array__ implementation doesn't accept:DeprecationWarning"),
    pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning"),
]
DESCRIPTION = """
preset: quick
set: {frame_count: 3, width_px: 160, height_px: 120}
pictures: png
splits: {train: 0.5, val: 0.5}
parts:
  rain:
    scenario: road-town
    set: {weather: rain, extent_m: 300, frame_outs: {count: 0}, vehicles: [sedan, MESH], target_vehicle: MESH}
  night:
    scenario: road-town
    set: {sun_elevation_deg: "uniform(-12, -6)", extent_m: 300, people: 20, frame_outs: {count: 0}}
  snow:
    scenario: road-town
    set: {weather: snow, snow_cover: 0.8, season: winter, extent_m: 300, traffic_cars: 4:12, frame_outs: {count: 0}}
  walk: {scenario: stereo-follow, set: {place: outdoors, people_builds: many}}
  tank: {scenario: fish-tank, preset: mixed}
episodes: 2
"""
TOWN = {"rain", "night", "snow"}
PARTS = TOWN | {"walk", "tank"}
REFUSED = {
    "coco-keypoints": TOWN,
    "kitti-flow": {"walk", "tank"},
    "kitti-forward-flow": {"walk", "tank"},
    "sintel-flow": {"walk", "tank"},
    "kitti-object": {"tank"},
    "kitti-stereo": TOWN | {"tank"},
}
"""Parts that a format has no place for, or that lack what it needs."""


def started(folder: Path, *words: str) -> subprocess.Popen[bytes]:
    command = [
        sys.executable,
        "-m",
        "benchmarks.cli.main",
        "generate",
        "--config",
        "set.yaml",
        "--workers",
        "0",
        *words,
    ]
    env = os.environ | {"PYTHONPATH": str(Path(__file__).parents[4])}
    return subprocess.Popen(command, cwd=folder, env=env)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder with the description, the mesh, and the set, ``one``."""
    folder = tmp_path_factory.mktemp("whole")
    box = trimesh.creation.box((4.6, 1.9, 1.6), translation_matrix((0.0, 0.0, 0.8)))
    stripes = np.tile(np.uint8([[[230, 60, 20]], [[250, 240, 220]]]), (8, 16, 1))
    picture = pytest.importorskip("PIL.Image").fromarray(stripes)
    box.visual = trimesh.visual.TextureVisuals(uv=box.vertices[:, :2] / (4.6, 1.9) + 0.5, image=picture)
    box.export(folder / "parcel.glb")
    (folder / "set.yaml").write_text(DESCRIPTION.replace("MESH", "parcel.glb@up=z@kind=van"))
    assert started(folder, "--out", "one").wait() == 0
    return folder


def test_kills_and_jobs_change_no_byte(made: Path) -> None:
    for count in (2, 6):
        run = started(made, "--out", "killed")
        while len(list((made / "killed").glob("*/episodes/0*/episode.json"))) < count and run.poll() is None:
            time.sleep(0.01)
        assert run.poll() is None
        run.kill()
        assert run.wait() == -signal.SIGKILL
    with pytest.raises(ValueError, match="out: expected all episodes of 0:2"):
        merge(made / "killed")
    assert started(made, "--out", "killed").wait() == 0
    for seed in ("1", "0"):
        assert started(made, "--out", "jobs", "--seeds", seed).wait() == 0
    merge(made / "jobs")
    assert digests(made / "killed") == digests(made / "one") == digests(made / "jobs")
    assert list(verify(made / "one")) == []


@pytest.mark.parametrize("name", sorted(READERS))
def test_each_export_is_read_by_its_own_reader(made: Path, tmp_path: Path, name: str) -> None:
    """Of the whole set, or of each part that the format takes. The mesh is not needed any more."""
    refused = REFUSED.get(name, set())
    if refused:
        with pytest.raises(ValueError, match=r"parts\.\w+\.data: expected "):
            export(made / "one", name, tmp_path / "out")
        assert not (tmp_path / "out").exists()
    else:
        export(made / "one", name, tmp_path / "out")
    for part in sorted(PARTS - refused):
        if refused:
            export(made / "one" / part, name, tmp_path / "out" / part)
        READERS[name](DataSet(str(made / "one" / part)), tmp_path / "out" / part)


def test_all_formats_are_read() -> None:
    assert READERS.keys() == {name for name, each in formats().items() if each.__module__.startswith("benchmarks.")}
