"""The example notebook runs from top to bottom, and is committed with the pictures that it makes."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks import Results

NOTEBOOK = Path(__file__).parents[1] / "examples" / "a_bench_in_python.ipynb"
LARGEST_BYTES = 150_000


def kinds_of(cell: dict[str, Any]) -> list[list[str]]:
    """Return the kinds of a cell's outputs, e.g. ``image/png``, without what it prints on stderr."""
    shown = (each for each in cell.get("outputs", ()) if each.get("name") != "stderr")
    return [sorted(each.get("data", {each["output_type"]: ""})) for each in shown]


@pytest.mark.heavy
def test_the_notebook_runs_and_shows_what_is_committed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("PYTHONPATH", str(NOTEBOOK.parents[1]))
    made = nbformat.read(NOTEBOOK, as_version=4)
    # The interpreter of the tests, whatever kernels this machine knows by name.
    client = nbclient.NotebookClient(made, timeout=300, resources={"metadata": {"path": str(tmp_path)}})
    client.create_kernel_manager().kernel_spec.argv[0] = sys.executable
    client.execute()
    committed = json.loads(NOTEBOOK.read_text())
    assert [kinds_of(cell) for cell in made.cells] == [kinds_of(cell) for cell in committed["cells"]]
    rows = Results(tmp_path / "results" / "notebook").rows()
    assert set(rows["tracker"]) == {"colour_pf", "road_shape_pf", "hold"}


def test_the_notebook_is_small_and_has_its_pictures() -> None:
    assert NOTEBOOK.stat().st_size < LARGEST_BYTES
    cells = json.loads(NOTEBOOK.read_text())["cells"]
    kinds = [kind for cell in cells for shown in kinds_of(cell) for kind in shown]
    assert {"image/jpeg", "image/png", "text/html"} <= set(kinds)
    assert "error" not in kinds
    assert all(cell["outputs"] for cell in cells if cell["cell_type"] == "code")


@pytest.mark.heavy
def test_the_robot_is_in_the_picture_and_does_not_pass_through_the_wall() -> None:
    pytest.importorskip("pybullet")
    driven = importlib.import_module("a_robot_in_the_building").drive()
    assert driven.way_m[60:, 0].max() > driven.way_m[0, 0] + 1.0, "it drives"
    # Its bumper is 0.5 m ahead of its middle.
    assert driven.way_m[:, 0].max() < driven.wall_x_m - 0.3
    assert np.ptp(driven.way_m[-30:, 0]) < 0.1, "the wall, or what stands before it, holds it"
    assert 0.02 < driven.is_robot.mean() < 0.5
    robot, around = driven.picture_rgb[driven.is_robot], driven.picture_rgb[~driven.is_robot]
    assert np.abs(robot.mean(axis=0) - around.mean(axis=0)).max() > 20, "a dark robot in a bright hall"
