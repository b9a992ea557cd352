"""The ratios on real tracks: beside the best simple method, weighted by gaps, with an interval over blocks."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from benchmarks.judges.fish.real_ratios import real_ratios


def row(tracker: str, block: int, metric: str, value: float, weight: float = 4.0) -> dict[str, Any]:
    return {"preset": "film", "tracker": tracker, "seed": block, "metric": metric, "value": value, "weight": weight}


def rows_of(tracker: str, metric: str, values: list[float], weights: list[float]) -> list[dict[str, Any]]:
    pairs = zip(values, weights, strict=True)
    return [row(tracker, block, metric, value, weight) for block, (value, weight) in enumerate(pairs)]


def numbers(line: str) -> list[float]:
    return [float(each) for each in re.findall(r"\d+\.\d{3}", line)]


def test_ours_stands_beside_the_simple_method_with_the_least_error() -> None:
    weights = [1.0, 3.0]
    rows = [
        *rows_of("shoal_chain", "gap_error_50_px", [80.0, 100.0], weights),
        *rows_of("fish_hold", "gap_error_50_px", [300.0, 100.0], weights),
        *rows_of("fish_damped_velocity", "gap_error_50_px", [100.0, 120.0], weights),
    ]
    lines = list(real_ratios(rows))
    assert len(lines) == 1
    assert "50 frames: shoal_chain / fish_damped_velocity" in lines[0]
    mean, low, high = numbers(lines[0])
    assert mean == pytest.approx((80 + 3 * 100) / (100 + 3 * 120), abs=1e-3)
    assert (low, high) == pytest.approx((80 / 100, 100 / 120), abs=1e-3)


def test_over_several_lengths_it_is_the_geometric_mean() -> None:
    rows = [
        row(tracker, block, f"gap_interpolation_error_{count}_px", error)
        for block in range(3)
        for tracker, errors in (("shoal_chain_shipped", (10.0, 30.0)), ("fish_linear", (20.0, 40.0)))
        for count, error in zip((50, 100), errors, strict=True)
    ]
    lines = [line for line in real_ratios(rows) if "50+100 frames: shoal_chain_shipped / fish_linear" in line]
    assert len(lines) == 1
    assert numbers(lines[0]) == pytest.approx([np.sqrt(0.5 * 0.75)] * 3, abs=1e-3)


def test_without_a_simple_method_nothing_is_said() -> None:
    assert list(real_ratios([row("shoal_chain", 0, "gap_error_50_px", 1.0)])) == []
