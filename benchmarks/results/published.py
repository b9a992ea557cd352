"""The published tables: plain data. ``frameout publish`` makes them, RESULTS.md shows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sim.checks import check


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedTable:
    """One published run.

    Attributes:
        name: of the table and its files.
        kind: the command that it repeats: ``frameout bench``, ``paper`` or ``speed``.
        suite: of a bench. scenario: catalogue id with its version, of a bench or a speed. preset: of the scenario.
        trackers, controllers: names; () = all of the scene. variants: whether these include ablations.
        experiment: of a paper, which sets scenario, preset and methods.
        renderer: raster or pybullet.
        seeds: of the episodes.
        keep_rows: whether the rows are committed, compressed.
        stored: whether a speed is that of data sets.
        frames: timed in each town of a speed.
    """

    name: str
    kind: Literal["bench", "paper", "speed"] = "bench"
    suite: str = ""
    scenario: str = ""
    preset: str = "standard"
    trackers: tuple[str, ...] = ()
    controllers: tuple[str, ...] = ()
    variants: bool = False
    experiment: str = ""
    renderer: Literal["raster", "pybullet"] = "raster"
    seeds: range
    keep_rows: bool = True
    stored: bool = False
    frames: int = 60


def _test_seeds(count: int) -> range:
    """Return the first seeds of the test split."""
    return range(10_000, 10_000 + count)


TABLES: tuple[PublishedTable, ...] = (
    PublishedTable(
        name="frame-out-standard", suite="frame-out", scenario="road-town-v2", variants=True, seeds=_test_seeds(200)
    ),
    PublishedTable(
        name="frame-out-hard", suite="frame-out", scenario="road-town-v2", preset="hard", seeds=_test_seeds(200)
    ),
    PublishedTable(
        name="frame-out-oblique", suite="frame-out", scenario="road-town-v2", preset="oblique", seeds=_test_seeds(200)
    ),
    PublishedTable(
        name="frame-out-steered",
        suite="frame-out",
        scenario="road-town-v2",
        controllers=("centre",),
        seeds=_test_seeds(50),
    ),
    PublishedTable(name="paper-a2", kind="paper", experiment="A2", seeds=_test_seeds(50)),
    PublishedTable(name="paper-a2-pybullet", kind="paper", experiment="A2", renderer="pybullet", seeds=_test_seeds(50)),
    PublishedTable(name="paper-a3", kind="paper", experiment="A3", seeds=_test_seeds(50)),
    PublishedTable(name="paper-a3-pybullet", kind="paper", experiment="A3", renderer="pybullet", seeds=_test_seeds(50)),
    PublishedTable(name="paper-b1", kind="paper", experiment="B1", seeds=_test_seeds(50)),
    PublishedTable(name="paper-b2", kind="paper", experiment="B2", seeds=_test_seeds(10)),
    # Ten drives have as many frames as the paper.
    PublishedTable(name="paper-b3", kind="paper", experiment="B3", seeds=_test_seeds(10)),
    PublishedTable(name="paper-c", kind="paper", experiment="C", seeds=_test_seeds(50)),
    # An episode is as long as the paper's, 70 minutes.
    PublishedTable(name="paper-d", kind="paper", experiment="D", seeds=_test_seeds(10)),
    PublishedTable(
        name="stereo-standard", suite="stereo", scenario="stereo-follow-v2", variants=True, seeds=_test_seeds(200)
    ),
    PublishedTable(
        name="stereo-hard", suite="stereo", scenario="stereo-follow-v2", preset="hard", seeds=_test_seeds(200)
    ),
    PublishedTable(
        name="stereo-paper-b3", suite="stereo", scenario="stereo-follow-v2", preset="paper-b3", seeds=_test_seeds(10)
    ),
    PublishedTable(name="fish-standard", suite="fish", scenario="fish-tank-v1", variants=True, seeds=_test_seeds(20)),
    PublishedTable(name="fish-hard", suite="fish", scenario="fish-tank-v1", preset="hard", seeds=_test_seeds(10)),
    PublishedTable(name="harbour-standard", suite="harbour", scenario="harbour-v1", seeds=_test_seeds(20)),
    PublishedTable(name="harbour-hard", suite="harbour", scenario="harbour-v1", preset="hard", seeds=_test_seeds(20)),
    PublishedTable(
        name="harbour-paper-d",
        suite="harbour",
        scenario="harbour-v1",
        preset="paper-d",
        variants=True,
        seeds=_test_seeds(20),
    ),
    PublishedTable(
        name="follow-road-town",
        suite="follow",
        scenario="road-town-v2",
        trackers=("mosaic_graph_pf", "colour_pf", "blind_turning", "oracle_target"),
        seeds=_test_seeds(50),
    ),
    PublishedTable(
        name="follow-stereo-follow",
        suite="follow",
        scenario="stereo-follow-v2",
        trackers=("stereo_people", "stereo_wb_shutter_gain", "blind_ahead", "oracle_target"),
        seeds=_test_seeds(50),
    ),
    PublishedTable(
        name="follow-fish-tank",
        suite="follow",
        scenario="fish-tank-v1",
        trackers=("shoal_chain", "ca_kalman", "oracle_target"),
        seeds=_test_seeds(10),
    ),
    PublishedTable(
        name="follow-harbour",
        suite="follow",
        scenario="harbour-v1",
        preset="patrol",
        trackers=("harbour_watch", "eigen_swarm", "oracle_target"),
        seeds=_test_seeds(10),
    ),
    PublishedTable(name="speed-road-town", kind="speed", scenario="road-town-v2", seeds=range(4)),
    PublishedTable(name="speed-stereo-follow", kind="speed", scenario="stereo-follow-v2", seeds=range(4)),
    PublishedTable(name="speed-fish-tank", kind="speed", scenario="fish-tank-v1", seeds=range(4)),
    PublishedTable(name="speed-harbour", kind="speed", scenario="harbour-v1", seeds=range(4)),
    PublishedTable(name="speed-stored", kind="speed", scenario="road-town-v2", stored=True, frames=300, seeds=range(2)),
)
"""In the order of RESULTS.md. A change of a table's data needs new runs."""


def tables_named(names: tuple[str, ...]) -> tuple[PublishedTable, ...]:
    """Return the tables of these names in the order of the list; () = all. Raises ValueError for an unknown name."""
    known = {table.name: table for table in TABLES}
    for name in names:
        check("tables", name in known, f"some of {', '.join(known)}", repr(name))
    return tuple(table for table in TABLES if table.name in (names or known))
