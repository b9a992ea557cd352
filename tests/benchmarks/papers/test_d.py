"""Paper experiment D: its claims are the paper's two tables, and rows are held against them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from benchmarks.contract.rows import Row, read_rows
from benchmarks.papers.experiment import experiment_named, findings
from benchmarks.statistics import froc
from scenarios import catalog
from tests.benchmarks.papers.conftest import row
from trackers import registry

EXPERIMENT = experiment_named("D")
WRITTEN, OURS = EXPERIMENT.trackers
KINDS = ["person"] * 15 + ["car"] * 3 + ["boat"]


def rows(found: Mapping[str, int], sizes_m: Mapping[str, float], tracker: str = WRITTEN) -> list[Row]:
    """Return the rows of an episode in which so many of each kind are found, with sizes ``width person`` …."""
    made = []
    for k, kind in enumerate(KINDS):
        event = {"index": k, "kind": kind}
        right = k - KINDS.index(kind) < found[kind]
        made.append(row(EXPERIMENT, tracker, "found_as_in_paper", float(right), event=event))
        for name, size_m in sizes_m.items():
            dimension, of = name.split()
            if of == kind and right:
                made.append(row(EXPERIMENT, tracker, f"region_{dimension}_m", size_m, event=event))
    return made


SIZES_M = {"person": {"width": 0.7, "depth": 2.3, "height": 1.8}, "car": {"width": 2.4, "depth": 2.9, "height": 2.5}}
PRINTED_M = {f"{name} {kind}": size_m for kind, sizes in SIZES_M.items() for name, size_m in sizes.items()}
SIZES = [f"region_{name}_m {kind}" for kind, sizes in SIZES_M.items() for name in sizes]
PRINTED = {"person": 12, "car": 2, "boat": 1}


def test_it_names_what_exists() -> None:
    preset = catalog.scenario(EXPERIMENT.scenario).presets[EXPERIMENT.preset]
    assert (preset.people, preset.cars, preset.boats, preset.background) == (15, 3, 1, 400)
    assert preset.frame_count / preset.rate_hz == 70 * 60
    assert [registry.entry(name).role for name in EXPERIMENT.trackers] == ["as-written", "ours"]
    for claim in EXPERIMENT.claims:
        assert EXPERIMENT.metric(claim.metric).name == claim.metric
        assert claim.tracker in EXPERIMENT.trackers


def test_the_paper_s_own_numbers_agree_with_it() -> None:
    found = {each.claim: each for each in findings(EXPERIMENT, rows(PRINTED, PRINTED_M))}
    by_metric = {claim.metric: each for claim, each in found.items() if claim.tracker == WRITTEN}
    assert by_metric["paper_detection_rate"].mean == pytest.approx(15 / 19)
    assert by_metric["paper_detection_rate_person"].mean == pytest.approx(0.8)
    assert by_metric["region_depth_m person"].mean == 2.3
    verdicts = [each.agrees for claim, each in found.items() if claim.metric in ("paper_detection_rate", *SIZES)]
    assert [each for each in verdicts if each is not None] == [True] * 7


@pytest.mark.parametrize(
    ("found", "width_m", "disagree"),
    [
        ({"person": 13, "car": 2, "boat": 1}, 0.5, []),
        ({"person": 14, "car": 2, "boat": 1}, 0.7, ["paper_detection_rate"]),
        ({"person": 10, "car": 2, "boat": 1}, 0.7, ["paper_detection_rate"]),
        (PRINTED, 0.46, ["region_width_m person"]),
        (PRINTED, 0.94, ["region_width_m person"]),
    ],
)
def test_eight_points_and_a_third(found: Mapping[str, int], width_m: float, disagree: list[str]) -> None:
    held = findings(EXPERIMENT, rows(found, PRINTED_M | {"width person": width_m}))
    wrong = [each.claim.metric for each in held if each.agrees is False and each.mean is not None]
    assert wrong == disagree


HELD = [
    (WRITTEN, "paper_detection_rate", True, 0.76, 0.08),
    (WRITTEN, "region_width_m person", False, 1.52, 0.3),
    (WRITTEN, "region_depth_m person", True, 1.66, 0.3),
    (WRITTEN, "region_height_m person", False, 2.80, 0.3),
    (WRITTEN, "region_width_m car", True, 3.11, 0.6),
    (WRITTEN, "region_depth_m car", False, 1.67, 0.3),
    (WRITTEN, "region_height_m car", True, 3.02, 0.3),
    (WRITTEN, "tide_share", True, 0.90, 0.08),
    (WRITTEN, "froc_area_1_100", True, -0.77, 0.12),
    (OURS, "detection_rate_at_a_tenth", True, 0.58, 0.15),
]
"""Tracker, metric, verdict, mean and how far off it may be, on seeds 30 and 31."""


@pytest.mark.heavy
def test_its_verdicts_hold_on_two_mornings_of_development(tmp_path: Path) -> None:
    alone = dataclasses.replace(EXPERIMENT, beside=(), robustness=None)
    alone.run(tmp_path, range(30, 32), "raster", 0, lambda done, of: None)
    found = [each for each in findings(EXPERIMENT, read_rows(tmp_path)) if each.agrees is not None]
    for each, (tracker, metric, agrees, mean, off) in zip(found, HELD, strict=True):
        print(each.claim.tracker, each.claim.metric, each.mean)
        assert (each.claim.tracker, each.claim.metric, each.agrees) == (tracker, metric, agrees)
        assert each.mean == pytest.approx(mean, abs=off), each.claim


def test_most_alarms_by_moored_boats() -> None:
    for tide, agrees in ((51.0, True), (50.0, False)):
        of = rows(PRINTED, {})[:1]
        alarms = {"false_alarms_per_hour": 100.0, "false_alarms_per_hour_tide": tide}
        of += [of[0] | {"metric": name, "value": value, "event": None} for name, value in alarms.items()]
        shares = {each.claim.tracker: each for each in findings(EXPERIMENT, of) if each.claim.metric == "tide_share"}
        share = shares[WRITTEN]
        assert (share.mean, share.agrees) == (tide / 100.0, agrees)


@pytest.mark.parametrize(("sure", "agrees"), [(0.9, True), (0.5, False)])
def test_ours_is_to_find_more_with_a_tenth_of_the_alarms(sure: float, agrees: bool) -> None:
    """Eigen swarm finds one of two with 50 alarms an hour, ours both, and from 0.7 on with 5 alarms."""
    of = []
    for tracker, found, alarms in ((WRITTEN, [1.0, 0.0], 50.0), (OURS, [1.0, 1.0], 8.0)):
        heading = rows({"person": 0, "car": 0, "boat": 0}, {}, tracker)[0] | {"event": None}
        surest = np.where(sure >= froc.THRESHOLDS, sum(found), 0.0)
        told = {
            "froc_found": surest.tolist(),
            "froc_findable": np.full(len(froc.THRESHOLDS), 2.0).tolist(),
            "froc_alarms": np.where(froc.THRESHOLDS < 0.7, alarms, 5.0).tolist(),
            "watched_hours": 1.0,
            "false_alarms_per_hour": alarms,
        }
        of += [heading | {"metric": name, "value": value} for name, value in told.items()]
        of += [heading | {"metric": "found", "value": value, "event": {"kind": "person"}} for value in found]
    (held,) = (each for each in findings(EXPERIMENT, of) if each.claim.metric == "detection_rate_at_a_tenth")
    assert (held.mean, held.agrees) == (pytest.approx(0.5 if agrees else -0.5), agrees)
