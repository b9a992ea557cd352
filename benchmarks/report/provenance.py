"""What was run: episodes, seeds, versions, failures, and the command that does it again. From rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.records import LAST_METRIC, Row, event_of
from benchmarks.report.numbers import ranges_text
from benchmarks.suites import suite

TEST_SPLIT = range(10_000, 20_000)


@dataclass(frozen=True, slots=True)
class Provenance:
    """What the page says of its making.

    Attributes:
        seeds, split: in words.
        episodes, frames: episodes of one tracker, and their frames.
        events: how many frame-outs or other events there are and of what kind, in words.
        command: repeats this part.
        versions: package or part → version or hash; several where rows differ.
        failures: one line for each episode in which a tracker failed.
    """

    seeds: str
    split: str
    episodes: int
    frames: int
    events: str
    command: str
    versions: dict[str, str]
    failures: tuple[str, ...]


def provenance(rows: Sequence[Row]) -> Provenance:
    """Return what is known of the rows of one condition (suite, scenario, preset, renderer, controller)."""
    seeds = sorted({row["seed"] for row in rows})
    frames = {row["seed"]: row["value"] for row in rows if row["metric"] == LAST_METRIC}
    return Provenance(
        seeds=ranges_text(seeds),
        split=_split(seeds),
        episodes=len(seeds),
        frames=int(sum(frames.values())),
        events=_events(rows),
        command=_command(rows[0], seeds, list(dict.fromkeys(row["tracker"] for row in rows))),
        versions=_versions(rows),
        failures=tuple(_failures(rows)),
    )


def _events(rows: Sequence[Row]) -> str:
    told = ((row["seed"], event) for row in rows if (event := event_of(row)) is not None)
    return suite(rows[0]["suite"]).events.describe(
        list({(seed, event["index"]): event for seed, event in told}.values())
    )


def _split(seeds: Sequence[int]) -> str:
    inside = sum(seed in TEST_SPLIT for seed in seeds)
    return "test split" if inside == len(seeds) else "development" if inside == 0 else "mixed splits"


def _command(row: Row, seeds: Sequence[int], trackers: Sequence[str]) -> str:
    parts = ["frameout", "bench", row["suite"], "--preset", row["preset"]]
    parts += ["--seeds", f"{seeds[0]}:{seeds[-1] + 1}", "--renderer", row["renderer"]]
    if row["controller"]:
        parts += ["--controllers", row["controller"]]
    return " ".join([*parts, "--trackers", *trackers])


def _versions(rows: Sequence[Row]) -> dict[str, str]:
    found: dict[str, list[str]] = {}
    for row in rows:
        for name, version in row["versions"].items():
            label = f"code of {row['tracker']}" if name == "tracker" else name
            label = "code of scene and scores" if name == "scene" else label
            if version not in found.setdefault(label, []):
                found[label].append(version)
    return {name: ", ".join(versions) for name, versions in found.items()}


def _failures(rows: Sequence[Row]) -> list[str]:
    return [
        f"{row['tracker']}, seed {row['seed']}: failed at frame {row['value']:.0f}; worst score from there on"
        for row in rows
        if row["metric"] == "failed_at_frame"
    ]
