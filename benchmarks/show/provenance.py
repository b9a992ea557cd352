"""Provenance of results from their rows: episodes, seeds, editions, failures, and the command that repeats them."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.contract.rows import HUMAN, LAST_METRIC, REAL, TEST_SPLIT, Row, event_of
from benchmarks.contract.suite import suite
from benchmarks.contract.text import ranges_text
from benchmarks.run.jobs import Job
from benchmarks.run.selection import SET_PATH
from scenarios import catalog


@dataclass(frozen=True, slots=True)
class Provenance:
    """The report's provenance of one condition.

    Attributes:
        unit: what ``seeds`` are: ``seed``; of what is real ``sequence``, whose names they are, or ``block`` of time.
        seeds, split: in words.
        episodes, frames: episodes of one tracker, and their frames.
        events: numbers and kinds of frame-outs or other events, in words.
        command: repeats this part.
        editions: package or part → its edition; several where rows differ.
        failures: one line for each episode in which a tracker failed.
    """

    unit: str
    seeds: str
    split: str
    episodes: int
    frames: int
    events: str
    command: str
    editions: dict[str, str]
    failures: tuple[str, ...]


def provenance(rows: Sequence[Row]) -> Provenance:
    """Return the provenance of the rows of one condition, see ``contract.suite.Condition``."""
    seeds = sorted({row["seed"] for row in rows})
    frames = {row["seed"]: row["value"] for row in rows if row["metric"] == LAST_METRIC}
    unit, named = _names(rows, seeds)
    return Provenance(
        unit=unit,
        seeds=named,
        split=_recorded(rows[0]) if rows[0]["scenario"] == REAL else _split(seeds),
        episodes=len(seeds),
        frames=int(sum(frames.values())),
        events=_events(rows),
        command=_command(rows, seeds),
        editions=_editions(rows),
        failures=tuple(_failures(rows)),
    )


def sequences_in_words(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a line about each folder of real sequences: how many, and their events, all and those that are judged."""
    for preset in sorted({row["preset"] for row in rows if row["scenario"] == REAL}):
        own = [row for row in rows if (row["scenario"], row["preset"]) == (REAL, preset)]
        held = provenance(own)
        judged = [(row["seed"], event_of(row)) for row in own if row["metric"] == "recovered"]
        returns = {(seed, event["index"]) for seed, event in judged if event is not None}
        count = f"{held.episodes} sequence{'s' if held.episodes > 1 else ''}, {held.frames} frames"
        yield f"{preset}: {count}; {held.events}; {len(returns)} with a return that is judged"


def _events(rows: Sequence[Row]) -> str:
    """Describe all events: shared by all trackers on a set path, of each tracker's own episodes in closed loop."""
    events: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in rows:
        event = event_of(row)
        if event is not None:
            episode = (row["controller"], row["tracker"]) if row["controller"] else ()
            events[(row["seed"], event["index"], *episode)] = event
    return suite(rows[0]["suite"]).events.describe(list(events.values()))


def _names(rows: Sequence[Row], seeds: Sequence[int]) -> tuple[str, str]:
    """Return what one episode is called, and the seeds, sequences or blocks of time."""
    sequences = {row["seed"]: row["sequence"] for row in rows if "sequence" in row}
    if sequences:
        return "sequence", ", ".join(sequences[seed] for seed in seeds)
    return "block" if rows[0]["scenario"] == REAL else "seed", ranges_text(seeds)


def _recorded(row: Row) -> str:
    return "real recording, blocks of time" if suite(row["suite"]).on_sequences is None else "real sequences"


def _split(seeds: Sequence[int]) -> str:
    inside = sum(seed in TEST_SPLIT for seed in seeds)
    return "test split" if inside == len(seeds) else "development" if inside == 0 else "mixed splits"


def _command(rows: Sequence[Row], seeds: Sequence[int]) -> str:
    row = rows[0]
    trackers = list(dict.fromkeys(each["tracker"] for each in rows))
    span = f"{seeds[0]}:{seeds[-1] + 1}"
    if all(each["controller"] == HUMAN for each in rows):
        env = next((name for name, (scenario, _) in catalog.envs().items() if scenario == row["scenario"]), "ENV")
        parts = ["frameout", "play", env, "--preset", row["preset"], "--tracker", row["tracker"], "--link", row["link"]]
        parts += ["--seeds", span]
    else:
        parts = ["frameout", "bench", row["suite"]]
        parts += row["recorded"] if row["scenario"] == REAL else _simulated(rows, span)
        parts += ["--trackers", *trackers]
        # The shortest of several: a tracker that it ended may not end under a longer one.
        limit_s = min(each.get("limit_s", Job.limit_s) for each in rows)
        parts += ["--limit-s", f"{limit_s:g}"] if limit_s != Job.limit_s else []
    modules = list(dict.fromkeys(each for some in rows for each in some.get("modules", ())))
    return shlex.join([*parts, "--modules", *modules] if modules else parts)


def _simulated(rows: Sequence[Row], span: str) -> list[str]:
    """Return the arguments of simulated episodes; of controllers neither a person nor a preset's own set path."""
    row, presets = rows[0], catalog.scenario(rows[0]["scenario"]).presets
    set_path = row["preset"] in presets and presets[row["preset"]].closed_loop
    steering = dict.fromkeys(each["controller"] for each in rows if each["controller"] != HUMAN)
    controllers = [each or SET_PATH for each in steering if each is not None or set_path]
    parts = ["--scenario", row["scenario"], "--preset", row["preset"], "--seeds", span, "--renderer", row["renderer"]]
    parts += ["--link", row["link"]] if suite(row["suite"]).judges_controllers else []
    return [*parts, "--controllers", *controllers] if controllers else parts


def _editions(rows: Sequence[Row]) -> dict[str, str]:
    found: dict[str, list[str]] = {}
    for row in rows:
        for name, version in row.get("editions", {}).items():
            if name == "scene" and row["scenario"] == REAL:
                continue  # One for each sequence, which has a name already.
            label = f"{name} {row[name]}" if name in ("tracker", "controller") else name
            if version not in found.setdefault(label, []):
                found[label].append(version)
    return {name: ", ".join(editions) for name, editions in found.items()}


def _failures(rows: Sequence[Row]) -> Iterator[str]:
    kinds = {
        "failed_at_frame": ("tracker", "worst score from there on"),
        "controller_failed_at_frame": ("controller", "no command from there on"),
    }
    for row in rows:
        if row["metric"] in kinds:
            kind, then = kinds[row["metric"]]
            episode = f"sequence {row['sequence']}" if "sequence" in row else f"seed {row['seed']}"
            yield f"{row[kind]}, {episode}: failed at frame {row['value']:.0f}; {then}"
