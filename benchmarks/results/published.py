"""The published tables: plain data. ``frameout publish`` makes them, RESULTS.md shows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scenarios.catalog import unversioned
from sim.checks import check


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedTable:
    """One published run.

    Attributes:
        name: of the table and its files.
        kind: the command that it repeats: ``frameout bench``, ``paper`` or ``speed``.
        suite: of a bench. scenario: catalogue id with its version, of a bench or a speed. preset: of the scenario.
        trackers, controllers: names; () = all of the scene. variants: whether these include ablations.
        without: trackers of the scene that are left out. parts_of: a tracker that stands alone with its ablations.
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
    without: tuple[str, ...] = ()
    parts_of: str = ""
    experiment: str = ""
    renderer: Literal["raster", "pybullet"] = "raster"
    seeds: range
    keep_rows: bool = True
    stored: bool = False
    frames: int = 60


def _test_seeds(count: int) -> range:
    """Return the first seeds of the test split."""
    return range(10_000, 10_000 + count)


_OPENCV = ("opencv_mil", "opencv_csrt")
"""They take as long as all others together: they have tables of their own, with fewer episodes."""

_PAPER_A = (
    "colour_pf",
    "colour_pf_tuned",
    "road_shape_pf",
    "road_shape_pf_tuned",
    "background_pf",
    "background_pf_tuned",
)
_PAPER_B = ("stereo_wb", "stereo_wb_tuned", "stereo_wb_shutter_gain", "stereo_wb_shutter_gain_tuned")
"""Methods of papers, as written and tuned."""


def _bench(
    name: str,
    suite: str,
    scenario: str,
    preset: str,
    episodes: int,
    *trackers: str,
    controllers: tuple[str, ...] = (),
    without: tuple[str, ...] = (),
    variants: bool = False,
    parts_of: str = "",
) -> PublishedTable:
    """Return a bench of the first episodes of the test split; other arguments: see ``PublishedTable``."""
    return PublishedTable(
        name=name,
        suite=suite,
        scenario=scenario,
        preset=preset,
        trackers=trackers,
        without=without,
        controllers=controllers,
        variants=variants,
        parts_of=parts_of,
        seeds=_test_seeds(episodes),
    )


def _paper(experiment: str, episodes: int, renderer: Literal["raster", "pybullet"] = "raster") -> PublishedTable:
    name = f"paper-{experiment.lower()}" + ("" if renderer == "raster" else f"-{renderer}")
    return PublishedTable(
        name=name, kind="paper", experiment=experiment, renderer=renderer, seeds=_test_seeds(episodes)
    )


def _steered(
    suite: str, scenario: str, preset: str, episodes: int, trackers: tuple[str, ...], controllers: tuple[str, ...]
) -> tuple[PublishedTable, ...]:
    """Return the table of controllers with each tracker and the truth, and that of the one that never moves.

    It does the same with each tracker, so that it runs with one.
    """
    name = f"{suite}-{unversioned(scenario)}"
    run = (suite, scenario, preset, episodes)
    return (
        _bench(name, *run, *trackers, "oracle_target", controllers=controllers),
        _bench(f"{name}-hold", *run, "oracle_target", controllers=("hold",)),
    )


def _speed(scenario: str) -> PublishedTable:
    return PublishedTable(name=f"speed-{unversioned(scenario)}", kind="speed", scenario=scenario, seeds=range(4))


TABLES: tuple[PublishedTable, ...] = (
    _bench("frame-out-standard", "frame-out", "road-town-v2", "standard", 200, without=_OPENCV),
    _bench("frame-out-hard", "frame-out", "road-town-v2", "hard", 200, without=_OPENCV),
    _bench("frame-out-oblique", "frame-out", "road-town-v2", "oblique", 60, without=_OPENCV),
    *(
        _bench(
            f"frame-out-{preset}-opencv",
            "frame-out",
            "road-town-v2",
            preset,
            12,
            *_OPENCV,
            "hold_ground",
            "mosaic_graph_pf",
        )
        for preset in ("standard", "oblique")
    ),
    _bench("frame-out-parts", "frame-out", "road-town-v2", "standard", 40, parts_of="mosaic_graph_pf"),
    *(
        _bench(f"frame-out-{preset}", "frame-out", "road-town-v2", preset, 40, "hold_ground", "mosaic_graph_pf")
        for preset in (
            "standard-left-hand",
            "standard-gipps",
            "standard-slow",
            "standard-fast",
            "standard-other-town",
        )
    ),
    _bench(
        "frame-out-steered",
        "frame-out",
        "road-town-v2",
        "standard",
        20,
        "mosaic_graph_pf",
        "hold_ground",
        "template_ground",
        *_PAPER_A,
        "blind_turning",
        controllers=("centre",),
    ),
    _paper("A2", 50),
    _paper("A2", 20, "pybullet"),
    _paper("A3", 50),
    _paper("A3", 20, "pybullet"),
    _paper("B1", 50),
    _paper("B2", 10),
    # Ten drives have as many frames as the paper.
    _paper("B3", 10),
    _paper("C", 25),
    # An episode is as long as the paper's, 70 minutes.
    _paper("D", 10),
    _bench("stereo-standard", "stereo", "stereo-follow-v2", "standard", 100, without=_OPENCV),
    _bench("stereo-hard", "stereo", "stereo-follow-v2", "hard", 50, without=_OPENCV),
    _bench(
        "stereo-paper-b3",
        "stereo",
        "stereo-follow-v2",
        "paper-b3",
        10,
        "stereo_people",
        "stereo_nearest",
        *_PAPER_B,
        "blind_ahead",
    ),
    _bench(
        "stereo-standard-opencv",
        "stereo",
        "stereo-follow-v2",
        "standard",
        12,
        *_OPENCV,
        "stereo_nearest",
        "stereo_people",
    ),
    _bench("stereo-parts", "stereo", "stereo-follow-v2", "standard", 20, parts_of="stereo_people"),
    _bench("fish-standard", "fish", "fish-tank-v1", "standard", 12, variants=True),
    _bench("fish-hard", "fish", "fish-tank-v1", "hard", 10),
    _bench("harbour-standard", "harbour", "harbour-v1", "standard", 10),
    _bench("harbour-hard", "harbour", "harbour-v1", "hard", 10),
    _bench("harbour-paper-d", "harbour", "harbour-v1", "paper-d", 10),
    _bench("harbour-watch-parts", "harbour", "harbour-v1", "paper-d", 5, parts_of="harbour_watch"),
    _bench("harbour-swarm-parts", "harbour", "harbour-v1", "paper-d", 5, parts_of="eigen_swarm"),
    _bench(
        "harbour-few-pictures",
        "harbour",
        "harbour-v1",
        "paper-d",
        5,
        *("harbour_watch", "harbour_watch_100_pictures", "harbour_watch_25_pictures"),
        *("eigen_swarm", "eigen_swarm_100_pictures", "eigen_swarm_25_pictures"),
    ),
    *_steered(
        "follow",
        "road-town-v2",
        "standard",
        20,
        ("mosaic_graph_pf", "template_ground", "colour_pf", "colour_pf_tuned", "blind_turning"),
        ("centre", "search", "reentry"),
    ),
    *_steered(
        "follow",
        "stereo-follow-v2",
        "standard",
        20,
        (
            "stereo_people",
            "stereo_colour_gate",
            "stereo_wb_shutter_gain",
            "stereo_wb_shutter_gain_tuned",
            "blind_ahead",
        ),
        ("centre", "search", "reentry"),
    ),
    *_steered(
        "follow",
        "fish-tank-v1",
        "standard",
        10,
        ("shoal_chain", "sort", "ca_kalman", "ca_kalman_tuned"),
        ("centre", "lead"),
    ),
    *_steered(
        "follow",
        "harbour-v1",
        "patrol",
        10,
        ("harbour_watch", "harbour_mog2", "harbour_mog2_tuned", "eigen_swarm"),
        ("centre", "lead"),
    ),
    *(_speed(scenario) for scenario in ("road-town-v2", "stereo-follow-v2", "fish-tank-v1", "harbour-v1")),
    PublishedTable(name="speed-stored", kind="speed", scenario="road-town-v2", stored=True, frames=300, seeds=range(2)),
)
"""In the order of RESULTS.md. A change of a table's data needs new runs."""


def tables_named(names: tuple[str, ...]) -> tuple[PublishedTable, ...]:
    """Return the tables of these names in the order of the list; () = all. Raises ValueError for an unknown name."""
    known = {table.name: table for table in TABLES}
    for name in names:
        check("tables", name in known, f"some of {', '.join(known)}", repr(name))
    return tuple(table for table in TABLES if table.name in (names or known))
