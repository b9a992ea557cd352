"""Counts, shares and medians of a data set, from its tables alone."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.page import scans
from sim.checks import check

_LEVELS = {"least": 0.0, "low": 5.0, "median": 50.0, "high": 95.0, "most": 100.0}
"""Name of a level of a distribution -> percentile."""


def statistics(data: DataSet) -> dict[str, Any]:
    """Return what a data set holds, as JSON values.

    Its keys: ``episodes``, ``missing_seeds``, ``frames``, ``seconds``, ``rate_hz``, ``objects`` (rows of the table);
    ``seen`` (kind -> group -> objects of frames that show at least one pixel);
    ``bytes`` (channel, or ``tables`` -> sum); ``states`` (group -> state -> share); ``frame_outs`` (group -> ``count``,
    ``unfinished`` and levels of their lengths in frames); ``box_side_px`` and ``visible_fraction`` (group -> levels);
    ``quantities`` (name -> ``unit``, ``table``, and under ``levels`` group -> levels, or for words ``shares``).
    Groups are ``target`` and ``other objects``, or ``""`` for what frames have; levels are least, 5 %, median, 95 %
    and most.

    Raises:
        ValueError: if there is no episode.
    """
    check_episodes(data)
    lengths = [len(data.episode(seed)) for seed in data.seeds]
    rates = [data.episode(seed).rate_hz for seed in data.seeds]
    return {
        "episodes": len(data.seeds),
        "missing_seeds": [seed for seed in range(*data.request.seeds) if seed not in set(data.seeds)],
        "frames": sum(lengths),
        "seconds": sum(length / rate for length, rate in zip(lengths, rates, strict=True)),
        "rate_hz": rates[0],
        "objects": data.count_rows("objects"),
        "seen": scans.seen_counts(data),
        "bytes": data.stored_bytes(),
        "states": state_shares(data),
        "frame_outs": {
            group: {"count": len(outs.lengths), "unfinished": outs.unfinished, **levels(outs.lengths)}
            for group, outs in scans.frame_outs(data).items()
        },
        "box_side_px": by_group(scans.box_sides_px(data)),
        "visible_fraction": by_group(scans.visible_fractions(data)),
        "quantities": {each.name: _quantity(data, each) for each in scans.quantities(data)},
    }


def check_episodes(data: DataSet) -> None:
    """Raise ValueError if a data set has no episode."""
    check("directory", len(data.seeds) > 0, "a data set with at least one whole episode", f"none in {data.url}")


def state_shares(data: DataSet) -> dict[str, dict[str, float]]:
    """Return the share of each state among the objects of all frames, by group."""
    counts = scans.state_counts(data)
    return {group: _shares(each) for group, each in counts.items()}


def levels(values: NDArray[Any]) -> dict[str, float]:
    """Return the levels of a distribution of values (K,), K > 0."""
    return {name: float(np.percentile(values, share)) for name, share in _LEVELS.items()}


def by_group(values: scans.ByGroup) -> dict[str, dict[str, float]]:
    """Return the levels of each group."""
    return {group: levels(each) for group, each in values.items()}


def _quantity(data: DataSet, quantity: scans.Quantity) -> dict[str, Any]:
    about = {"unit": quantity.unit, "table": quantity.table}
    if quantity.kind == "word":
        return about | {"shares": _shares(scans.words(data, quantity))}
    found = scans.numbers(data, quantity)
    if quantity.kind == "flag":
        return about | {"shares": {group: float(each.mean()) for group, each in found.items()}}
    return about | {"levels": by_group(found)}


def _shares(counts: dict[str, int]) -> dict[str, float]:
    total = sum(counts.values())
    return {name: count / total for name, count in counts.items()}
