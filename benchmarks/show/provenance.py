"""Provenance of results from their rows: episodes, seeds, editions, failures, and the command that repeats them."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from benchmarks.contract.rows import HUMAN, LAST_METRIC, REAL, TEST_SPLIT, Row, event_of
from benchmarks.contract.suite import Suite, suite
from benchmarks.contract.text import counted, ranges_text
from benchmarks.run.jobs import Job
from benchmarks.run.selection import SET_PATH
from scenarios import catalog


def provenance(rows: Sequence[Row]) -> dict[str, Any]:
    """Return the provenance of the rows of one condition, see ``contract.suite.Condition``, in words.

    ``unit``: what ``seeds`` are: ``seed``; of what is real ``sequence``, whose names they are, or ``block`` of time;
    ``split``; ``episodes`` of one tracker, and their ``frames``; ``events``: numbers and kinds of frame-outs or other
    events; ``command`` that repeats this part; ``editions``: package or part → its edition, several where rows differ;
    ``failures``: one line for each episode in which a tracker failed.
    """
    seeds, is_real = sorted({row["seed"] for row in rows}), rows[0]["scenario"] == REAL
    sequences = {row["seed"]: row["sequence"] for row in rows if "sequence" in row}
    tested = sum(seed in TEST_SPLIT for seed in seeds)
    split = {0: "development", len(seeds): "test split"}.get(tested, "mixed splits")
    if is_real:
        split = "real sequences" if sequences else "real recording, blocks of time"
    return {
        "unit": "sequence" if sequences else "block" if is_real else "seed",
        "seeds": ", ".join(sequences[seed] for seed in seeds) if sequences else ranges_text(seeds),
        "split": split,
        "episodes": len(seeds),
        "frames": int(sum({row["seed"]: row["value"] for row in rows if row["metric"] == LAST_METRIC}.values())),
        "events": suite(rows[0]["suite"]).events.describe(events_in(rows)),
        "command": _commands(rows, f"{seeds[0]}:{seeds[-1] + 1}"),
        "editions": _editions(rows),
        "failures": list(_failures(rows)),
    }


def sequences_in_words(judging: Suite, rows: Sequence[Row]) -> Iterator[str]:
    """Yield a line about each folder of real sequences that a suite judges: how many, and their events, all and those
    that are judged; rows of other suites are left out.
    """
    real = [row for row in rows if (row["suite"], row["scenario"]) == (judging.name, REAL)]
    for preset in sorted({row["preset"] for row in real}) if judging.on_sequences is not None else ():
        own = [row for row in real if row["preset"] == preset]
        held = provenance(own)
        line = f"{preset}: {counted(held['episodes'], 'sequence')}, {counted(held['frames'], 'frame')}"
        if not judging.follows_many:
            judged = [(row["seed"], event_of(row)) for row in own if row["metric"] == "recovered"]
            returns = {(seed, event["index"]) for seed, event in judged if event is not None}
            line += f"; {held['events']}; {len(returns)} with a return that is judged"
        yield line


def events_in(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """Return the attributes of all events of a condition: shared by all trackers on a set path, of each tracker's own
    episodes in closed loop.
    """
    events: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in rows:
        event = event_of(row)
        if event is not None:
            episode = (row["controller"], row["tracker"]) if row["controller"] else ()
            events[(row["seed"], event["index"], *episode)] = event
    return list(events.values())


def _commands(rows: Sequence[Row], span: str) -> str:
    """Return the command of trackers that ran, and those of predictions made elsewhere."""
    ran = [row for row in rows if "predicted" not in row]
    commands = [_command(ran, span)] if ran else []
    for predicted in dict.fromkeys(tuple(row["predicted"]) for row in rows if "predicted" in row):
        row = next(each for each in rows if each.get("predicted") == list(predicted))
        of_scenario = ["--truth", row["scenario"], "--preset", row["preset"], "--seeds", span]
        parts = ["score", row["suite"], *(row["recorded"] if row["scenario"] == REAL else of_scenario), *predicted]
        commands.append(shlex.join(["frameout", *parts, *(["--modules", *row["modules"]] if "modules" in row else [])]))
    return " && ".join(commands)


def _command(rows: Sequence[Row], span: str) -> str:
    row, judged = rows[0], suite(rows[0]["suite"])
    steering = dict.fromkeys(each["controller"] for each in rows)
    modules = dict.fromkeys(each for some in rows for each in some.get("modules", ()))
    if steering.keys() == {HUMAN}:
        env = next((name for name, (scenario, _) in catalog.envs().items() if scenario == row["scenario"]), "ENV")
        parts = ["play", env, "--preset", row["preset"], "--tracker", row["tracker"], "--link", row["link"]]
        parts += ["--seeds", span]
    else:
        parts = ["bench", row["suite"]]
        if row["scenario"] == REAL:
            parts += row["recorded"]
        else:
            parts += ["--scenario", row["scenario"], "--preset", row["preset"], "--seeds", span]
            parts += ["--renderer", row["renderer"]]
            parts += ["--link", row["link"]] if judged.judges_controllers else []
            # Neither a person nor a preset's own set path is named.
            scene, preset = catalog.scenario(row["scenario"]), row["preset"]
            own_path = not (scene.has_preset(preset) and scene.configuration(preset).closed_loop)
            named = [each or SET_PATH for each in steering if each != HUMAN and (each is not None or not own_path)]
            parts += ["--controllers", *named] if named else []
        parts += ["--trackers", *dict.fromkeys(each["tracker"] for each in rows)]
        for argument in dict.fromkeys(each["process"] for each in rows if "process" in each):
            parts += ["--process", argument]
        parts += ["--real-time", f"{row['real_time_hz']:g}"] if "real_time_hz" in row else []
        runs = {each["tracker"]: 1 + each["repeat"] for each in sorted(rows, key=lambda each: each["repeat"])}
        parts += ["--repeats", str(least)] if (least := min(runs.values())) > 1 else []
        # The shortest of several: a tracker that it ended may not end under a longer one.
        limit_s = min(each.get("limit_s", Job.limit_s) for each in rows)
        parts += ["--limit-s", f"{limit_s:g}"] if limit_s != Job.limit_s else []
    return shlex.join(["frameout", *parts, *(["--modules", *modules] if modules else [])])


def _editions(rows: Sequence[Row]) -> dict[str, str]:
    found: dict[str, dict[str, None]] = {}
    for row in rows:
        for name, version in row.get("editions", {}).items():
            # Those of real sequences have a name already.
            if name != "scene" or row["scenario"] != REAL:
                label = f"{name} {row[name]}" if name in ("tracker", "controller") else name
                if name == "tracker" and "predicted" in row:
                    # Without the digest of a sequence's file.
                    version = version.rpartition(" ")[0]
                found.setdefault(label, {})[version] = None
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
