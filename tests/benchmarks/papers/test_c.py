"""Paper experiment C: its claims are the paper's table, and rows are held against them."""

from __future__ import annotations

import pytest

from benchmarks.contract.suite import suite
from benchmarks.papers.experiment import experiment_named, findings
from scenarios import catalog
from tests.benchmarks.papers.conftest import row
from trackers import registry

EXPERIMENT = experiment_named("C")


def verdicts(errors_px: tuple[float, float, float]) -> dict[str, bool | None]:
    counts = (50, 100, 200)
    rows = [
        row(EXPERIMENT, "ca_kalman", f"gap_error_{count}_px", error)
        for count, error in zip(counts, errors_px, strict=True)
    ]
    return {each.claim.metric: each.agrees for each in findings(EXPERIMENT, rows) if each.claim.tracker == "ca_kalman"}


def test_it_names_what_exists() -> None:
    preset = catalog.scenario(EXPERIMENT.scenario).presets[EXPERIMENT.preset]
    assert not preset.closed_loop
    roles = {name: registry.entry(name).role for name in EXPERIMENT.trackers}
    assert list(roles.values()) == ["as-written", "ours"]
    assert all(EXPERIMENT.suite in registry.entry(name).suites for name in roles)
    for claim in EXPERIMENT.claims:
        assert suite(EXPERIMENT.suite).metric(claim.metric).unit in ("px", "1")
        assert claim.tracker in EXPERIMENT.trackers


def test_the_paper_s_own_numbers_agree_with_it() -> None:
    agreed = verdicts((0.60, 1.05, 2.81))
    assert agreed == dict.fromkeys(agreed, True)
    assert len(agreed) == 5


@pytest.mark.parametrize(
    ("errors_px", "disagree"),
    [
        ((0.61, 1.06, 2.82), set()),
        ((0.85, 1.05, 2.81), {"gap_error_50_px"}),
        ((0.60, 1.05, 4.00), {"gap_error_200_px", "gap_growth_200"}),
        # In another unit the growth is the same.
        ((6.0, 10.5, 28.1), {"gap_error_50_px", "gap_error_100_px", "gap_error_200_px"}),
    ],
)
def test_a_tolerance_of_forty_per_cent(errors_px: tuple[float, float, float], disagree: set[str]) -> None:
    agreed = verdicts(errors_px)
    assert {name for name, yes in agreed.items() if not yes} == disagree


@pytest.mark.parametrize(
    ("written_px", "ours_px", "agrees"),
    [
        # Episodes differ by more than the methods do: what counts is the difference on each.
        ((1.0, 5.0, 9.0, 13.0), (0.9, 4.8, 8.9, 12.8), True),
        ((1.0, 5.0, 9.0, 13.0), (0.9, 5.1, 8.9, 12.9), False),
        ((1.0, 5.0, 9.0, 13.0), (1.1, 5.2, 9.1, 13.2), False),
    ],
)
def test_ours_is_nearer_where_the_paired_interval_is_clear_of_zero(
    written_px: tuple[float, ...], ours_px: tuple[float, ...], agrees: bool
) -> None:
    named = {"ca_kalman": written_px, "shoal_chain": ours_px}
    rows = [
        row(EXPERIMENT, name, "gap_error_50_px", px, seed)
        for name, each in named.items()
        for seed, px in enumerate(each)
    ]
    (found,) = (
        each
        for each in findings(EXPERIMENT, rows)
        if each.claim.minus == "ca_kalman" and each.claim.metric == "gap_error_50_px"
    )
    assert found.mean == pytest.approx(sum(ours_px) / 4 - sum(written_px) / 4)
    assert (found.agrees, found.episodes, found.expected) == (agrees, 4, "interval below 0 px")


def test_ours_stands_beside_it_without_a_verdict() -> None:
    rows = [row(EXPERIMENT, "shoal_chain", f"gap_error_{count}_px", 0.3) for count in (50, 100, 200)]
    found = [each for each in findings(EXPERIMENT, rows) if each.claim.tracker == "shoal_chain"]
    assert [(each.mean, each.agrees) for each in found if not each.claim.minus] == [(0.3, None)] * 3
    # Alone it has nothing to be compared with.
    assert [(each.mean, each.agrees) for each in found if each.claim.minus] == [(None, False)] * 3
