"""The published tables: plain data. ``python -m tools publish`` makes them, RESULTS.md shows them."""

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
        trackers, controllers: of a bench, by name.
        experiment: of a paper, which sets scenario, preset and methods.
        seeds: of the episodes.
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
    experiment: str = ""
    seeds: range
    stored: bool = False
    frames: int = 60


def _test_seeds(count: int) -> range:
    """Return the first seeds of the test split."""
    return range(10_000, 10_000 + count)


# In town and building neither variants nor OpenCV's trackers, which take as long as all others together and decide
# nothing: they stand among the earlier figures.
_OF_A_CAR = (
    "hold",
    "constant_velocity",
    "hold_ground",
    "constant_velocity_ground",
    "template_ground",
    "colour_pf",
    "colour_pf_tuned",
    "road_shape_pf",
    "road_shape_pf_tuned",
    "background_pf",
    "background_pf_tuned",
    "mosaic_graph_pf",
    "blind_carried",
    "blind_straight",
    "blind_turning",
    "blind_below",
    "oracle_map",
    "oracle_driver",
)
_OF_A_PERSON = (
    "stereo_wb",
    "stereo_wb_tuned",
    "stereo_wb_shutter_gain",
    "stereo_wb_shutter_gain_tuned",
    "stereo_nearest",
    "stereo_colour_gate",
    "stereo_people",
    "blind_ahead",
)
_OF_INTRUDERS = (
    "harbour_watch",
    "harbour_watch_tuned",
    "eigen_swarm",
    "eigen_swarm_learnt_confidence",
    "harbour_mog2",
    "harbour_mog2_tuned",
    "harbour_posts",
    "harbour_blind",
)
"""Of the background models MOG2 alone: the better of its two was ahead of the others, which stand among the earlier
figures.
"""

_OF_FISH = (
    "sort",
    "sort_appearance",
    "bytetrack",
    "shoal_chain",
    "ca_kalman",
    "ca_kalman_tuned",
    "fish_hold",
    "fish_constant_velocity",
    "fish_damped_velocity",
    "fish_linear",
    "fish_hermite",
    "fish_mean_place",
    "fish_middle",
    "fish_wall_ahead",
)
_VARIANTS_OF_OURS = ("shoal_chain_tuned", "shoal_chain_motion")
"""Among ten fish alone, as they take half of the time among a hundred. Motion alone shows what looks are worth."""


def _bench(
    name: str,
    suite: str,
    scenario: str,
    preset: str,
    episodes: int,
    *trackers: str,
    controllers: tuple[str, ...] = (),
) -> PublishedTable:
    """Return a bench of the first episodes of the test split; other arguments: see ``PublishedTable``."""
    return PublishedTable(
        name=name,
        suite=suite,
        scenario=scenario,
        preset=preset,
        trackers=trackers,
        controllers=controllers,
        seeds=_test_seeds(episodes),
    )


def _paper(experiment: str, episodes: int) -> PublishedTable:
    name = f"paper-{experiment.lower()}"
    return PublishedTable(name=name, kind="paper", experiment=experiment, seeds=_test_seeds(episodes))


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
    return PublishedTable(name=f"speed-{unversioned(scenario)}", kind="speed", scenario=scenario, seeds=range(3))


TABLES: tuple[PublishedTable, ...] = (
    _bench("frame-out-standard", "frame-out", "road-town-v2", "standard", 28, *_OF_A_CAR),
    _bench("frame-out-hard", "frame-out", "road-town-v2", "hard", 14, *_OF_A_CAR),
    _bench("frame-out-oblique", "frame-out", "road-town-v2", "oblique", 8, *_OF_A_CAR),
    _paper("A2", 16),
    _paper("A3", 20),
    _paper("B1", 20),
    _paper("B2", 10),
    _paper("B3", 4),
    _paper("C", 4),
    # An episode is as long as the paper's, 70 minutes.
    _paper("D", 4),
    _bench("stereo-standard", "stereo", "stereo-follow-v2", "standard", 16, *_OF_A_PERSON),
    _bench("stereo-hard", "stereo", "stereo-follow-v2", "hard", 10, *_OF_A_PERSON),
    _bench("fish-standard", "fish", "fish-tank-v1", "standard", 5, *_OF_FISH, *_VARIANTS_OF_OURS),
    _bench("fish-hard", "fish", "fish-tank-v1", "hard", 3, *_OF_FISH),
    _bench("harbour-standard", "harbour", "harbour-v1", "standard", 4, *_OF_INTRUDERS),
    _bench("harbour-hard", "harbour", "harbour-v1", "hard", 4, *_OF_INTRUDERS),
    *_steered(
        "follow",
        "road-town-v2",
        "standard",
        6,
        ("mosaic_graph_pf", "template_ground", "colour_pf_tuned", "blind_turning"),
        ("centre", "search", "reentry"),
    ),
    *_steered(
        "follow",
        "stereo-follow-v2",
        "standard",
        4,
        ("stereo_people", "stereo_colour_gate", "stereo_wb_shutter_gain_tuned", "blind_ahead"),
        ("centre", "search", "reentry"),
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
