"""Rows: the source of every table, plot and page.

``records.jsonl`` holds one JSON object a line. Every row has these keys:

======================  ================================================================================
``suite``               ``frame-out``, ``stereo``, ``fish``, ``harbour``, ``follow``; ``paper`` for experiments that
                        measure a camera and run no tracker
``scenario``, ``preset``  ``road-town-v2``, ``standard`` …; of real tracks ``real`` and the recording's name
``tracker``, ``role``   registry name and role (``ours`` ``variant`` ``as-written`` ``tuned`` ``baseline`` ``blind``
                        ``oracle``); suite ``paper``: ``none`` and ``measured``; suite ``follow``: the
                        *controller's* role (``ours`` ``policy`` ``baseline`` ``variant`` …)
``tracker_role``        suite ``follow`` alone: the role of the tracker
``controller``          name of the controller that steered the camera; null on a set path
``link``                suite ``follow`` alone: how commands reach the carrier, ``scenarios.command_link.LINKS``
``renderer``            ``raster`` or ``pybullet``; ``real`` for recordings
``seed``                the episode's seed; of recordings the number of a block of 500 frames, or of a ``sequence``
``sequence``            of real sequences of pictures: the name of the sequence
``blocks``              of recordings of tracks: how many blocks of time the tracker has there
``modules``             names or files of users' own modules of the run; only where there were any
``recorded``            of recordings: the arguments of ``frameout bench`` that say which, and how they are read
``repeat``              0; 0, 1, 2 for trackers that no seed makes reproducible
``metric``              what ``value`` is, see below
``value``               a number; or a list of numbers (a *series*); null = undefined (left out of means)
``weight``              how much the value counts in a mean over rows, e.g. the frames it is a mean of
``frame_out``           suites ``frame-out`` and ``paper``: null for rows about the whole episode; else the
                        frame-out that the row is about::

                            {"index": 0, "exit_frame": 57, "length_frames": 43, "back_frame": 104 or null,
                             "kind": "road" | "excursion" | "unseen", "side": "left"|"right"|"top"|"bottom",
                             "turned": true if it turned at a crossing while outside}

                        ``back_frame`` is the first frame on which the whole car is in the picture again;
                        null if it left again, or the episode ended, before that. ``length_frames`` counts
                        frames wholly outside.
``event``               suite ``stereo``, in place of ``frame_out``: null for rows about the whole episode; else the
                        stretch of frames that the row is about::

                            {"index": 2, "kind": "occlusion" | "lamp on" | "lamp off" | "back light" | "doorway"
                             | "shade" | "near person" | "nobody near", "first_frame": 57, "length_frames": 8,
                             "back_frame": 66 or null, "place": "hall", "light": true of a change of light}

                        ``back_frame`` is the first frame after an occlusion on which half of the target is seen;
                        null if it was hidden again, or the episode ended, before that, and of other events. A
                        change of light is the two seconds from its beginning on.
``event``               suites ``fish`` and ``harbour``: null, or ``fish.links.FishGap`` or ``harbour.visits.Visit``
``event``               suite ``follow``: null for rows about the whole episode; else the loss it is about::

                            {"kind": "loss", "index": 0, "first_frame": 57, "length_frames": 43,
                             "back_frame": 100 or null}

                        a stretch longer than 1 s on which the target was out of view.
``seconds``             wall time of the episode with this tracker (not reproducible)
``editions``            of scene, judge, tracker, controller and packages that made the row, see ``run.editions``
======================  ================================================================================

Rows of one (suite, scenario, preset, tracker, controller, renderer, link, seed) are one *block*, written at once.
The last row of a block has the metric ``frames`` (number of frames); a block without it was cut off, is
ignored and made again. Replaced rows are moved to ``records.outdated-1.jsonl``, ``-2`` and so on.

Rows about one frame-out (suite ``frame-out``):

=================================  =====================================================================
``recovered``                      1 if on the car within 5 frames after ``back_frame``, else 0
``kept``                           1 if recovered and still on the car one second later, else 0
``recovery_frames``                frames from ``back_frame`` to the first one on the car; null = never
``watched_frames``                 frames from ``back_frame`` to the next exit or the episode's end: where
                                   ``recovery_frames`` is null the time to recover is censored here. Both are
                                   given of every frame-out with a ``back_frame``
``locked_on_wrong_car``            1 if on one other vehicle, not the target, in most of the frames
                                   ``back_frame`` … ``back_frame + 5``
``reentry_error_m``                error on the last frame wholly outside
``had``                            1 if on the car at the exit: on the last frame before it or the first outside
``offscreen_error_m``              mean error outside, weighted by the number of frames
``offscreen_error_30_m``, ``_100_m``  error 30 / 100 frames after the exit (only if it lasts that long)
``offscreen_error_if_had_m`` …     the same three again, only if the tracker had the car at the exit
``offscreen_error_by_frame_m``     *series*: error on each frame outside; entry k is k frames after the exit
=================================  =====================================================================

``recovered``, ``kept`` and ``locked_on_wrong_car`` exist for the same frame-outs, chosen by the truth alone: those
with at least 5 frames and one second of the episode after ``back_frame``. (In closed loop the tracker steers: there
``exit_frame`` counts, and a car that never returns is not recovered.)

Rows of suite ``frame-out`` about the whole episode: ``coverage_50/90/95`` and ``nees`` (frames outside; null for a
tracker without a posterior in the episode; for others a frame without one is a miss, with the capped NEES),
``credible_level_histogram`` (*series* of 20: share of outside frames whose truth lay at level 0-5 %, 5-10 % … of the
posterior; flat = calibrated), ``offscreen_error_car_lengths``, ``in_view_tpr``, ``in_view_tnr``, ``precision_curve``
and ``recall_curve`` (*series* over ``statistics.long_term.THRESHOLDS``), ``centre_error_px``, ``precision_20_px``,
``success_auc``, ``success_curve`` (*series* over ``metrics.localisation.THRESHOLDS``), ``time_seen``, ``time_in_view``
and ``losses_per_minute`` (closed loop only, see ``judges.view_time``), ``run_kept`` (1 if every frame-out that can be
judged was kept), ``silent_frames``, the times (see ``judges.tracker_speed.times``), ``failed_at_frame`` (only if the
tracker failed), ``frames``. For real sequences see ``frame_out.real``.

Rows of suite ``stereo`` about events, see ``metrics.people`` for the classes of frames:

=================================  =====================================================================
``recovered``                      occlusions with at least 10 frames of the episode after ``back_frame``: 1 if
                                   right within 10 frames after it, else 0
``recovery_frames``                frames from ``back_frame`` to the first right one; null = never
``watched_frames``                 frames from ``back_frame`` to the next occlusion or the episode's end
``locked_on_wrong_person``         1 if on one other person in most of the frames
                                   ``back_frame`` … ``back_frame + 10``, of the same occlusions
``event_right_frames``, ``event_wrong_frames``, ``event_missed_frames``, ``event_wrong_person_rate``
                                   other events: the same as of the whole episode, of their frames alone
=================================  =====================================================================

Rows of suite ``stereo`` about the whole episode but its first frame: ``right_frames``, ``wrong_frames``,
``missed_frames`` (A, B and C, of which precision, recall, F and F1 are made), ``wrong_person_rate`` (share of all
frames), ``position_error_m`` (frames on which at least a tenth of the target is seen), ``position_error_found_m``
(frames with a right answer), ``outcome_by_frame`` (*series* of ``metrics.people.Outcome``, frame 0 included),
``visible_fraction_by_frame`` (*series*), ``rate_hz``, ``silent_frames``, the times,
``failed_at_frame``, ``frames``. ``stereo.disparity``, the same for all trackers of the same pictures, on every tenth
pair whose right picture is not lost, over pixels that both cameras see:
``disparity_error_px_GROUP`` (median absolute error, at full size), ``disparity_bad_1_GROUP``, ``disparity_bad_3_GROUP``
(shares of the known disparities with a larger error) and ``disparity_density_GROUP`` (share of pixels that have one).
GROUP is ``all``, ``target`` (the target's pixels) or a place (all pixels while the target is there).

Rows of suite ``fish`` are defined in its modules: ``judge.chain_scores``, ``link_scores``, ``gap_scores``, ``motion``,
``identity_series``; ``_at_once`` marks immediate answers; of suite ``harbour``: ``found``, ``alarms``, ``sizes`` ….

Rows of suite ``follow``, formulas in ``metrics.following`` and ``judges.view_time``; about a loss: ``recovery_frames``
(from leaving view to being in view again; null = never) and ``watched_frames`` (the same, or to the episode's end);
about the whole episode: ``rate_hz``, ``time_seen``, ``time_in_view``, ``losses_per_minute``, ``centring_error``,
``effort``, ``jerkiness_per_s``, ``dat_cumulative_reward``, ``dat_tsr``, ``episode_length_steps``, ``sr_500``, people's
``evt_success_rate``, ``evt_tracking_rate`` and ``evt_collision_rate``; of the tracker's answers ``in_view_tpr``,
``in_view_tnr``, ``wrong_target_rate`` and ``silent_frames``; then the times of the tracker,
``failed_at_frame``, and in every suite ``controller_failed_at_frame`` (only if the controller failed), ``frames``.
Beside it lie ``summary.json``, ``comparisons.json`` (``statistics.summary``), the report, ``estimates`` if asked for.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from sim.checks import check

FILE_NAME = "records.jsonl"
LAST_METRIC = "frames"
REAL: Final = "real"
"""Scenario and renderer of real recordings; preset: recording, or folder of sequences; seed: its block, or sequence."""
ESTIMATES = "estimates"
"""Folder beside the rows with all answers, see ``benchmarks.data.estimates``."""
TEST_SPLIT = range(10_000, 20_000)
"""Seeds of published figures; no parameter is chosen on them."""
HUMAN = "human"
"""Controller in rows of a person who played; the role is ``external``."""

Row = dict[str, Any]
_NAMED: dict[str, Any] = {
    **dict.fromkeys(("suite", "scenario", "preset", "renderer", "tracker", "metric"), str),
    **{"controller": str | None, "seed": int, "value": object},
}


@dataclass(frozen=True, order=True, slots=True)
class BlockKey:
    """Identity of a block of rows: one tracker in one episode. ``link`` is "" in suites without links."""

    suite: str
    scenario: str
    preset: str
    renderer: str
    controller: str
    tracker: str
    seed: int
    link: str = ""


def block_key(row: Row) -> BlockKey:
    """Return the key of a row's block; a set path has the controller ""."""
    where = (row["suite"], row["scenario"], row["preset"], row["renderer"], row["controller"] or "")
    return BlockKey(*where, row["tracker"], row["seed"], row.get("link", ""))


EVENT_COLUMNS = ("event", "frame_out")
"""Columns with the attributes of the event that a row is about; a suite has one of them."""


def event_of(row: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the attributes of a row's event; None for rows about the whole episode."""
    return next((row[name] for name in EVENT_COLUMNS if row.get(name)), None)


@dataclass(frozen=True, slots=True)
class Contents:
    """Contents of a file of rows.

    Attributes:
        blocks: whole blocks in canonical order; the later one of duplicates.
        replaced: lines of blocks that were cut off or made again. broken: lines that are no rows.
    """

    blocks: dict[BlockKey, list[Row]]
    replaced: list[bytes]
    broken: list[bytes]


def read(directory: Path) -> Contents:
    """Return the contents of a directory's rows. Raises ValueError if it holds no records."""
    path = directory / FILE_NAME
    check("directory", path.is_file(), f"one that holds {FILE_NAME}", repr(str(directory)))
    return blocks_of_lines(path.read_bytes().splitlines())


def blocks_of_lines(lines: Iterable[bytes]) -> Contents:
    """Return the contents of the lines of a file of rows."""
    whole: dict[BlockKey, list[tuple[bytes, Row]]] = {}
    growing: list[tuple[bytes, Row]] = []
    replaced: list[tuple[bytes, Row]] = []
    broken: list[bytes] = []
    for line in lines:
        row = _parsed(line)
        if growing and (row is None or block_key(growing[0][1]) != block_key(row)):
            replaced += growing
            growing = []
        if row is None:
            broken.append(line)
            continue
        growing.append((line, row))
        if row["metric"] == LAST_METRIC:
            replaced += whole.get(block_key(row), [])
            whole[block_key(row)] = growing
            growing = []
    blocks = {key: [row for _, row in whole[key]] for key in sorted(whole)}
    return Contents(blocks, [line for line, _ in (*replaced, *growing)], broken)


def read_blocks(directory: Path) -> dict[BlockKey, list[Row]]:
    """Return the whole blocks of a directory, see ``read``."""
    return read(directory).blocks


def read_rows(directory: Path) -> list[Row]:
    """Return all rows of whole blocks in canonical order."""
    return list(itertools.chain.from_iterable(read_blocks(directory).values()))


def lines_of(rows: Sequence[Row]) -> bytes:
    """Return rows as they stand in a file."""
    return "".join(json.dumps(row) + "\n" for row in rows).encode()


def rounded(value: float | list[float] | None) -> float | list[float] | None:
    """Return a value as stored in rows: six significant digits, null if not finite."""
    if isinstance(value, list):
        return [_six_digits(each) for each in value]  # type: ignore[misc]
    return None if value is None else _six_digits(value)


def _six_digits(value: float) -> float | None:
    return float(f"{value:.6g}") if abs(value) < float("inf") else None


def _parsed(line: bytes) -> Row | None:
    """Return the row of a line, None if it is none: torn, not UTF-8, or without the naming columns."""
    try:
        row = json.loads(line.decode())
    except ValueError:
        return None
    whole = isinstance(row, dict) and row.keys() >= _NAMED.keys()
    return row if whole and all(isinstance(row[name], kind) for name, kind in _NAMED.items()) else None
