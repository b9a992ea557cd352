"""Groups of visits in comparisons."""

from __future__ import annotations

import pytest

from benchmarks.contract.suite import suite


@pytest.mark.parametrize(
    ("contrast", "group"),
    [
        (4.9, []),
        (5.0, ["5 to 150"]),
        (149.9, ["5 to 150"]),
        (150.0, ["150 to 300"]),
        (400.0, ["300 to 1000"]),
        (1000.0, ["from 1000"]),
        (9000.0, ["from 1000"]),
    ],
)
def test_every_visit_that_can_be_seen_is_in_one_group_of_contrast(contrast: float, group: list[str]) -> None:
    words = "contrast to noise "
    event = {"contrast_to_noise": contrast}
    groups = [
        name.removeprefix(words)
        for name, is_one in suite("harbour").events.tests.items()
        if words in name and is_one(event)
    ]
    assert groups == group


def test_all_that_visits_have_of_their_own_is_compared_by_contrast() -> None:
    compared = {each.name for metric in suite("harbour").events.compared for each in metric.statistic.of}
    sizes = {"width_error", "height_error", "depth_error"}
    assert compared == {"found", "time_to_detect_s", "position_error_m", "kind_right", "duplicate_rate", *sizes}
