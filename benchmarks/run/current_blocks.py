"""The blocks of an experiment that a folder has already, made by the present code."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from benchmarks.run.records import FILE_NAME, HUMAN, BlockKey, read_blocks, tidy
from sim.checks import check

ESTIMATES = "estimates"
"""Folder beside the rows with all answers, see ``benchmarks.estimates``."""

MadeNow = Callable[[BlockKey], dict[str, str] | None]
"""Returns the current ``versions`` of a block of the experiment, None for other blocks."""


def current_blocks(out: Path, seeds: range, made_now: MadeNow) -> tuple[set[BlockKey], list[str]]:
    """Return the up-to-date blocks of an experiment in a folder, and messages about outdated ones, which are moved to
    another file.

    Raises:
        ValueError: for a folder that holds rows of other seeds.
    """
    if not (out / FILE_NAME).is_file():
        return set(), []
    blocks = read_blocks(out)
    # A person may have played other episodes.
    strangers = [key.seed for key in blocks if key.controller != HUMAN and key.seed not in seeds]
    wanted = f"a folder with no seeds but {seeds.start}:{seeds.stop}, e.g. an empty one"
    check("out", not strangers, wanted, f"{str(out)!r}, which holds seed {min(strangers, default=None)}")
    mine = {key: made for key in blocks if (made := made_now(key)) is not None}
    outdated = {key for key, made in mine.items() if blocks[key][0].get("versions") != made}
    return mine.keys() - outdated, list(filter(None, [tidy(out, outdated)]))


def with_estimates(out: Path, have: set[BlockKey], made_now: MadeNow) -> set[BlockKey]:
    """Return those blocks that have whole estimates of the same ``versions``."""
    # An extra, which runs that keep no estimates do without.
    from benchmarks.estimates.block_file import is_kept

    return {key for key in have if is_kept(out / ESTIMATES, key, made_now(key))}
