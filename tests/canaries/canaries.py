"""Canaries: digests of what scenes draw, trackers answer, controllers command and suites judge.

An edition in a row promises that the same edition makes the same row. A canary is a small run whose digest is kept in
``digests.json`` beside the edition that made it. If the digest is another one under the same edition, either the
edition must be raised, or the change was not meant.

Trackers, controllers and suites get the stored episodes in ``episodes``, so that a change of a scene is no change of
theirs. They were made by ``frameout generate SCENARIO --preset quick --pictures jpeg`` with another size and number of
frames, as ``dataset.json`` in each of them says. The harbour's trackers get drawn pictures, as they need a
background.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cache, partial
from itertools import groupby
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest import mock

import numpy as np
from llvmlite.binding import get_host_cpu_name
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Judge, Score
from benchmarks.contract.suite import Suite, suite
from benchmarks.contract.track_table import TrackTable
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.data.sets.data_set import stored_episode
from benchmarks.data.sets.stored_episode import StoredEpisode
from benchmarks.judges.fish.real import FishRecording
from benchmarks.papers import b1, b2
from benchmarks.papers.camera_experiment import CameraExperiment, SheetPicture
from benchmarks.papers.experiment import experiment_named
from benchmarks.run.editions import controller_edition, judge_edition, preset_edition, tracker_edition
from benchmarks.run.episodes import ForeseeingController, simulated
from benchmarks.run.selection import trackers_of
from scenarios import catalog
from scenarios.catalog import unversioned
from scenarios.command_link import LINKS, episode_link
from scenarios.loop import Loop, LoopTracker, ManyLoopTracker, tracker_stream
from scenarios.road_town.plan import draw_layout
from scenarios.road_town.scenario import KeptTown
from scenarios.road_town.town import build_town, forget_town
from scenarios.scenario import Frame, KeptWorld
from scenarios.stage import Stage
from scenarios.truth import Truth, meanings
from sim.checks import check
from sim.rng import episode_seed, generator
from tests.trackers.drawn_harbour import CAMERA, SURVEY, DrawnHarbour
from trackers.controllers.catalogue import ControllerEntry, controllers
from trackers.follow_one import FollowOne
from trackers.gaps import Bridge, GapMethod, Piece, Surroundings
from trackers.types import (
    CameraCommand,
    CameraModel,
    CameraRegisters,
    Estimate,
    Observation,
    SiteSurvey,
    Start,
    Track,
)

HERE = Path(__file__).parent
DIGESTS = HERE / "digests.json"
EPISODES = {"road-town": 0, "stereo-follow": 2, "fish-tank": 0, "harbour": 0}
"""Stored episode -> its seed."""
THROUGH_HEADS = {"fish-tank-ptz": 0, "harbour-ptz": 0}
"""The same, of scenes whose trackers look through the head that is steered: for controllers and such trackers."""
WATCHED = {
    "frame-out": "road-town",
    "stereo": "stereo-follow",
    "fish": "fish-tank",
    "harbour": "harbour",
    "many": "fish-tank",
}
"""Suite -> stored episode that its trackers watch."""
WATCHED_FRAMES = {"road-town": 72, "stereo-follow": 30, "fish-tank": 36, "harbour": 16}
"""How long trackers watch: the car is outside from frame 31 to 60, the person hidden from 26 to 29."""
_BACKGROUND = 30
"""Pictures of the drawn harbour before its trackers begin."""
_TINY = {"width_px": 64, "height_px": 48, "extent_m": 300.0, "background": 2}
"""Fields of presets that have them -> smaller values."""
_FRAMES = 3
_SHEET_PICTURES = 40
_NEAR_ZERO = 1e-12
_DRAWN = "precision_plot"
"""Rows of which no metric is made: no edition stands for them."""
_COURSE = 60
"""Later frames of a set path, of which no picture is taken."""
_COMMAND = CameraCommand(1.0, 0.5, 0.2, 0.1, 0.1, 0.05, 0.02)
_IN_THE_SAME_TOWN = (
    *("hard", "quick", "oblique", "standard-gipps", "standard-slow", "standard-fast"),
    *("rain", "fog", "snow"),
)
"""Presets of ``road-town`` that take place in the town of ``standard``, in closed loop: building a town takes longest
of all.
"""


def processor_key() -> str:
    """Return what the digests of this kind of processor are called.

    Kernels of fast floating-point numbers take ``vrsqrtps``, of which a maker bounds the error only. AMD's estimate is
    another one than Intel's, so that a pixel may be rounded to the next grey level, or a last bit differs. Most digests
    are the same on both, and stand once.
    """
    return "digest_amd" if get_host_cpu_name().startswith(("znver", "bdver", "btver")) else "digest"


@dataclass(frozen=True)
class Canary:
    """A thing with an edition, and a digest of what it does.

    Attributes:
        name: kind and name.
        edition: as rows have it.
        raise_at: where the number of the edition stands.
        digest: runs the thing.
        settings: preset or parameters, of which the edition has those that are not the defaults, and the digest feels
            few in so short a run.
    """

    name: str
    edition: str
    raise_at: str
    digest: Callable[[], str]
    settings: Any = None

    @property
    def values(self) -> dict[str, str]:
        """The settings by name, those within others too."""
        return dict(_values(self.settings, "")) if self.settings is not None else {}


def _values(settings: Any, prefix: str) -> Iterator[tuple[str, str]]:
    for field in dataclasses.fields(settings):
        value = getattr(settings, field.name)
        if dataclasses.is_dataclass(value):
            yield from _values(value, f"{prefix}{field.name}.")
        elif field.name != "summary":
            yield prefix + field.name, repr(value)


def canaries() -> dict[str, Canary]:
    """Return all canaries by name."""
    return {each.name: each for each in (*_scenes(), *_trackers(), *_controllers(), *_suites(), *_papers())}


def _scenes() -> Iterator[Canary]:
    for name in catalog.names():
        scenario = catalog.scenario(name)
        for preset in scenario.presets:
            yield Canary(
                f"scene {name} {preset}",
                preset_edition(name, preset),
                f"the version in the id of {name}",
                lambda name=name, preset=preset: digest_of_scene(name, preset),
                scenario.presets[preset],
            )
        # Those of the town share one in closed loop.
        if "quick" in scenario.presets and unversioned(name) != "road-town":
            yield Canary(
                f"scene {name} steered",
                preset_edition(name, "quick"),
                f"the version in the id of {name}",
                lambda name=name: digest_of_scene(name, "quick", closed_loop=True),
            )


ELSEWHERE = ("opencv_csrt",)
"""Trackers of an environment that not every machine has."""


def _trackers() -> Iterator[Canary]:
    for name, tracker in trackers_of().items():
        if name not in ELSEWHERE and tracker.reproducible and _watched(tracker):
            yield Canary(
                f"tracker {name}",
                tracker_edition(tracker),
                f"edition= where {name} is registered, {tracker.module}",
                lambda tracker=tracker: digest_of_tracker(tracker),
                tracker.parameters,
            )


def _watched(tracker: TrackerSpec) -> list[tuple[str, str]]:
    """Return the suites of a tracker, each with the stored episode that the tracker watches."""
    watched = WATCHED | {"follow": "fish-tank-ptz"}
    return [(name, stored) for name, stored in watched.items() if name in tracker.suites]


def _controllers() -> Iterator[Canary]:
    for stored in (*EPISODES, *THROUGH_HEADS):
        for name, entry in controllers(catalog.scenario(stored).carrier.name).items():
            yield Canary(
                f"controller {entry.carrier} {name}",
                controller_edition(entry)["controller"],
                f"edition= where {name} is registered, {entry.controller.__module__}",
                lambda stored=stored, entry=entry: digest_of_controller(entry, stored),
                entry.parameters(),
            )


def shipped() -> set[str]:
    """Return the names that canaries of all registered trackers and controllers have."""
    trackers = {name for name, tracker in trackers_of().items() if tracker.reproducible} - set(ELSEWHERE)
    carriers = {catalog.scenario(unversioned(name)).carrier.name for name in catalog.names()}
    return {f"tracker {name}" for name in trackers} | {
        f"controller {carrier} {name}" for carrier in carriers for name in controllers(carrier)
    }


def _suites() -> Iterator[Canary]:
    runs: dict[str, Callable[[Suite], str]] = dict.fromkeys((*WATCHED, "follow"), digest_of_suite)
    runs |= {"frame-out on sequences": digest_on_sequences, "fish on recordings": digest_on_recordings}
    for name, run in runs.items():
        judging = suite(name.partition(" ")[0])
        yield Canary(
            f"suite {name}",
            judge_edition(judging),
            f"edition= of the suite, {judging.judge.__module__.rpartition('.')[0]}.suite",
            lambda judging=judging, run=run: run(judging),
        )


def _papers() -> Iterator[Canary]:
    for name, module in (("B1", b1), ("B2", b2)):
        made = experiment_named(name)
        assert isinstance(made, CameraExperiment)
        yield Canary(
            f"paper {made.name}",
            f"{made.name} {made.edition}",
            f"edition in benchmarks/papers/{name.lower()}.toml",
            lambda module=module, made=made: digest_of_measurement(module, made),
        )


def digest_of_measurement(module: ModuleType, made: CameraExperiment) -> str:
    """Return the digest of what an experiment measures on drawn pictures of a sheet, in place of its scene's."""
    with mock.patch.object(module, "photograph", _drawn_sheet):
        return digest(made.measure(0, "raster"))


def _drawn_sheet(*_: Any, **held: bool) -> Iterator[SheetPicture]:
    rng = np.random.default_rng(zlib.crc32(repr(sorted(held.items())).encode()))
    for k in range(_SHEET_PICTURES):
        picture_rgb = rng.integers(20 + k, 200 - 3 * k, (24, 32, 3), dtype=np.uint8)
        registers = CameraRegisters(400 + 9 * k, 500 + 13 * k, 90 + 20 * (k % 17), 10 * (k % 23))
        yield SheetPicture(picture_rgb, registers, np.array([8.0, 6.0, 24.0, 18.0]), 609.0 / (1 + k))


def digest_of_scene(name: str, preset: str, closed_loop: bool | None = None) -> str:
    """Return the digest of a tiny edition of an episode: pictures and truths of the first frames, what is given before
    them, and where everything is later on.
    """
    scenario = catalog.scenario(name)
    tiny = _tiny(scenario.presets[preset])
    make = partial(scenario.episode, closed_loop=closed_loop)
    if unversioned(name) == "road-town" and preset in _IN_THE_SAME_TOWN:
        make = partial(scenario.episode, closed_loop=True, kept=_town(name))
    with closing(make(tiny, 0)) as episode:
        commands = [_COMMAND if k and episode.closed_loop else None for k in range(_FRAMES)]
        seen = [episode.step(command) for command in commands]
        return digest([seen, episode.start, episode.rate_hz, episode.frame_count, _course(episode)])


def _tiny(preset: Any) -> Any:
    return dataclasses.replace(preset, **{name: value for name, value in _TINY.items() if hasattr(preset, name)})


@cache
def _town(name: str) -> KeptWorld:
    """Return a town of an edition as sharp as the catalogue's."""
    seed = episode_seed(0, name, 0)
    layout = draw_layout(_tiny(catalog.scenario(name).presets["standard"]), seed)
    return KeptWorld(build_town(layout, generator(seed, "town")), KeptTown(layout))


def forget_towns() -> None:
    """Build the next towns anew."""
    forget_town()
    _town.cache_clear()


def _course(episode: Stage) -> Iterator[Any]:
    """Yield where bodies and camera are after the first frames, without a picture."""
    # A carrier moves from frame to frame, set paths are known beforehand.
    count = episode.frame_count - _FRAMES if episode.closed_loop else _COURSE
    for frame in np.linspace(_FRAMES, episode.frame_count - 1, count).astype(int).tolist():
        if episode.closed_loop:
            episode._obey(_COMMAND)
        episode._move_to(frame)
        yield episode.world.poses, episode._T_world_camera


def digest_of_tracker(spec: TrackerSpec) -> str:
    """Return the digest of a tracker's answers on what its suite has to watch.

    Raises:
        ValueError: if it never answers, so that its digest tells nothing.
    """
    name, stored = _watched(spec)[0]
    judging, episode, seed = suite(name), _Again(stored), _seed(stored)
    rng = tracker_stream(seed, spec.name)
    tracker = spec.create(simulated(stored, "quick", seed), episode, rng, many=judging.follows_many)
    if stored == "harbour":
        answers = list(_in_the_drawn_harbour(tracker))
    else:
        loop = Loop(episode, [tracker])
        answers = [loop.answers[0] for _ in loop.frames(count=WATCHED_FRAMES.get(stored))]
    bridges = isinstance(tracker, ManyLoopTracker) and tracker.gap_method() is not None
    check("tracker", bridges or any(map(_says_something, answers)), "one that answers", repr(spec.name))
    return digest([answers, *_hindsight(tracker)])


def _in_the_drawn_harbour(tracker: LoopTracker) -> Iterator[Any]:
    """Yield the answers while two people walk on the quay."""
    harbour = DrawnHarbour(0)
    start = Start(CAMERA, background=tuple(harbour.pictures(_BACKGROUND)), site=SURVEY)
    for k in range(WATCHED_FRAMES["harbour"]):
        walkers_m = [np.array([2.0, -6.0 + 0.7 * k]), np.array([6.0, 5.0 - 0.5 * k])]
        frame = Frame(harbour.picture(walkers_m), frames_of("harbour")[0].truth)
        yield tracker.update(frame) if k else tracker.initialise(frame, start)


def _says_something(answer: Any) -> bool:
    return bool(np.isfinite(answer.position_px).all() if isinstance(answer, Estimate) else answer)


def _hindsight(tracker: LoopTracker) -> Iterator[Any]:
    if isinstance(tracker, ManyLoopTracker):
        yield from (tracker.revised(), tracker.decides_at())
        if (method := tracker.gap_method()) is not None:
            yield from _bridges(method)


def _bridges(method: GapMethod) -> Iterator[Any]:
    """Yield what a method predicts for a gap of ten frames in the track of each stored fish."""
    places = np.stack([frame.truth.position_px for frame in frames_of("fish-tank")], axis=1)
    interval_s = 1.0 / _stored("fish-tank").rate_hz
    tracks = [Piece(0, each, interval_s) for each in places]
    method.learn([Piece(0, each[:30], interval_s) for each in places])
    around = Surroundings(np.array([0.0, 0.0, 160.0, 120.0]), tracks[1:])
    for each in places:
        past, future = Piece(0, each[:30], interval_s), Piece(40, each[40:], interval_s)
        yield method.extrapolate(past, 10, around)
        yield method.interpolate(past, future, around)


def digest_of_suite(judging: Suite) -> str:
    """Return the digest of the rows of written answers on the stored episodes of a suite's scenes."""
    if not judging.judges_controllers:
        return digest(_rows(judging, WATCHED[judging.name]))
    return digest([(_rows(judging, name), _sent(name)) for name in EPISODES])


def digest_on_sequences(judging: Suite) -> str:
    """Return the digest of the rows of written answers on the stored car, as a sequence with boxes alone."""
    assert judging.on_sequences is not None
    judge = judging.on_sequences.judge(_Again("road-town"))
    return digest(_judged(judge, "road-town", [written_estimate]))


def digest_on_recordings(judging: Suite) -> str:
    """Return the digest of the rows of a written method on the places of the stored fish."""
    places_px = np.stack([frame.truth.position_px for frame in frames_of("fish-tank")])
    table = TrackTable("stored", places_px, tuple(map(str, range(places_px.shape[1]))), 30.0)
    scores = FishRecording(table).scores(Ending(new_gap_method=_LastPlace))
    blocks = groupby(scores, key=lambda score: score.block)
    return digest((block.index, [_without_block(score) for score in mine]) for block, mine in blocks if block)


def _without_block(score: Score) -> dict[str, Any]:
    return {name: getattr(score, name) for name in ("metric", "value", "weight", "event")}


def _sent(stored: str) -> Iterator[CameraCommand]:
    """Yield what a carrier receives of written commands, over each link that changes them."""
    for link in (LINKS[name] for name in ("prompt", "delayed", "noisy")):
        sender = episode_link(catalog.scenario(stored).carrier, _stored(stored).rate_hz, link, seed=0)
        yield from (sender.send(dataclasses.replace(_COMMAND, forward_mps=0.3 * k)) for k in range(8))


def _rows(judging: Suite, stored: str) -> Iterator[Any]:
    judge = judging.judge(_Again(stored), catalog.scenario(stored))
    many = judging.follows_many
    return _judged(judge, stored, [written_tracks] if many else [written_estimate, _reduced()], steered=not many)


def _judged(
    judge: Judge, stored: str, answering: Sequence[Callable[[Frame], Any]], steered: bool = False
) -> Iterator[Any]:
    sheets = [judge.sheet() for _ in answering]
    for frame in frames_of(stored):
        judge.see(frame, CameraCommand(0.1 * frame.truth.frame) if frame.truth.frame and steered else None)
        for sheet, answer in zip(sheets, answering, strict=True):
            sheet.keep(frame, answer(frame))
    for sheet in sheets:
        for score in sheet.scores(Ending()):
            if score.metric != _DRAWN:
                event = None if score.event is None else score.event.attributes()
                yield score.metric, score.value, score.weight, event


def _reduced() -> Callable[[Frame], Estimate]:
    """Return the answers of ``FollowOne`` with written tracks, started on the second object."""
    follower = FollowOne(_Written())

    def answer(frame: Frame) -> Estimate:
        _Written.tracks = written_tracks(frame)
        if frame.truth.frame == 0:
            follower.initialise(frame.observation, frame.truth.box_xyxy[1])
            return Estimate(frame.truth.position_px[1])
        return follower.update(frame.observation)

    return answer


class _Written:
    """A ``MultiTracker`` whose answers are written elsewhere."""

    tracks: list[Track]

    def start(self, background: Iterable[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        return self.tracks


class _LastPlace:
    """A ``GapMethod``: a target stays where it was last."""

    def learn(self, pieces: Sequence[Piece]) -> None:
        """See ``GapMethod``."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        return Bridge(np.tile(past.position_px[-1], (count, 1)), np.tile(100.0 * np.eye(2), (count, 1, 1)))

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge:
        """See ``GapMethod``."""
        return self.extrapolate(past, future.first_frame - past.end_frame, around)


def written_estimate(frame: Frame) -> Estimate:
    """Return a written answer about the target: near, then ever farther off, and none on every ninth frame."""
    truth = frame.truth
    target = 1 if len(truth.names) > 1 else 0
    if truth.frame % 9 == 8:
        return Estimate(np.full(2, np.nan))
    off_px = np.array([0.13, -0.07]) * (truth.frame % 25)
    return Estimate(
        truth.position_px[target] + off_px,
        box_xyxy=truth.box_xyxy[target] + np.tile(off_px, 2),
        heading_rad=0.05 * truth.frame,
        in_view_probability=0.1 + 0.8 * (truth.frame % 5) / 4,
        covariance_px=np.diag([4.0, 9.0]) * (1 + truth.frame % 7),
    )


def written_tracks(frame: Frame) -> list[Track]:
    """Return written tracks: two swap their names half-way, one is missing now and then, one is nowhere."""
    truth = frame.truth
    tracks = []
    for k in range(len(truth.names)):
        there = truth.state[k] in ("in", "partial") and (truth.frame + k) % 11
        if there:
            identity = k if truth.frame < 20 or k > 1 else 1 - k
            off_px = np.array([0.4, 0.3]) * (k % 3)
            estimate = Estimate(truth.position_px[k] + off_px, box_xyxy=truth.box_xyxy[k] + np.tile(off_px, 2))
            size_m = None if not hasattr(truth, "size_m") else 1.1 * truth.size_m[k]
            tracks.append(Track(identity, estimate, size_m=size_m, confidence=0.3 + 0.1 * (k % 7)))
    nowhere = Estimate(np.array([9.0, 7.0]), box_xyxy=np.array([5.0, 4.0, 13.0, 10.0]))
    return [*tracks, Track(99, nowhere, kind="person", size_m=np.array([0.5, 0.5, 1.7]), confidence=0.55)]


@cache
def _stored(name: str) -> StoredEpisode:
    return stored_episode(str(HERE / "episodes" / name), _seed(name))


def _seed(stored: str) -> int:
    return (EPISODES | THROUGH_HEADS)[stored]


def digest_of_controller(entry: ControllerEntry, stored: str) -> str:
    """Return the digest of a controller that watches a stored episode; one that foresees episodes, of its start."""
    made, frames = entry.create(), frames_of(stored)
    if isinstance(made, ForeseeingController):
        scenario = catalog.scenario(stored)
        made.foresee(scenario.id, scenario.presets["quick"], _seed(stored), LINKS["prompt"])
        frames = frames[:_FRAMES]
    return digest(made.command(frame.observation, written_estimate(frame)) for frame in frames)


@cache
def frames_of(name: str) -> list[Frame]:
    """Return all frames of a stored episode, which is read once."""
    return [_with_depth(_stored(name).step()) for _ in range(_stored(name).frame_count)]


def _with_depth(frame: Frame) -> Frame:
    """Return a frame whose depth, which takes too much room to be stored, is that of a wall, with one object in it."""
    rows, columns = frame.observation.image_rgb.shape[:2]
    maps = {"depth_m": np.full((rows, columns), 5.0, np.float32), "instance_map": np.ones((rows, columns), np.int32)}
    maps |= {f"right_{name}": values for name, values in maps.items() if hasattr(frame.truth, f"right_{name}")}
    return dataclasses.replace(frame, truth=dataclasses.replace(frame.truth, **maps))


class _Again:
    """A stored episode from its first frame on, see ``scenarios.scenario.Episode``."""

    def __init__(self, name: str) -> None:
        self._episode, self._frames = _stored(name), iter(frames_of(name))

    def __getattr__(self, name: str) -> Any:
        """Return what the stored episode has."""
        return getattr(self._episode, name)

    def step(self, command: CameraCommand | None = None) -> Frame:
        """See ``Episode``."""
        return next(self._frames)


def digest(held: Any) -> str:
    """Return a digest of values: dataclasses, arrays, mappings, iterables, numbers and texts."""
    content = hashlib.sha256()
    for part in _parts(held):
        content.update(part)
    return content.hexdigest()[:16]


def _parts(held: Any) -> Iterator[bytes]:
    if dataclasses.is_dataclass(held):
        # No row follows from a field that no judge reads.
        left_out = (
            [name for name, meaning in meanings(held).items() if not meaning.judged] if isinstance(held, Truth) else []
        )
        # Digests are older than masks and quays with corners.
        left_out += ["mask"] if isinstance(held, Estimate) and held.mask is None else []
        left_out += ["outline_m"] if isinstance(held, SiteSurvey) and not held.outline_m else []
        held = {each.name: getattr(held, each.name) for each in dataclasses.fields(held) if each.name not in left_out}
    if isinstance(held, float):
        held = np.array(held)
    if isinstance(held, np.ndarray):
        numbers = _rounded(held) if held.dtype.kind == "f" else held
        yield f"{held.dtype}{held.shape}".encode() + np.ascontiguousarray(numbers).tobytes()
    elif isinstance(held, Mapping):
        for name, each in held.items():
            yield str(name).encode()
            yield from _parts(each)
    elif isinstance(held, Iterable) and not isinstance(held, str):
        yield b"["
        for each in held:
            yield from _parts(each)
        yield b"]"
    else:
        yield f"{held!r};".encode()


def _rounded(numbers: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    """Return numbers to about a millionth of each: their last bits are those of a machine."""
    mantissa, exponent = np.frexp(np.where(np.abs(numbers) < _NEAR_ZERO, 0.0, numbers))
    return np.ldexp(np.round(mantissa * 2.0**20), exponent - 20)


def kept() -> dict[str, dict[str, Any]]:
    """Return the kept digests: name -> ``edition``, ``digest`` and ``values``."""
    return json.loads(DIGESTS.read_text()) if DIGESTS.is_file() else {}


def verdict(canary: Canary, known: Mapping[str, Mapping[str, Any]]) -> str:
    """Return what a canary says, "" if all is as it was."""
    before = known.get(canary.name)
    if before is None or before["edition"] != canary.edition:
        was = "none" if before is None else f"one of {before['edition']!r}"
        return f"{canary.name}: expected a digest of {canary.edition!r}, got {was}; python -m tests.canaries keeps one"
    remedy = f"Raise {canary.raise_at}; or, if nothing was to change, undo what did it"
    # A new setting changes nothing by itself.
    changed = [name for name, value in canary.values.items() if before["values"].get(name, value) != value]
    if changed:
        return f"{canary.name}: {', '.join(changed)} had other values in the edition {canary.edition!r}. {remedy}"
    digest, key = canary.digest(), processor_key()
    if digest not in ([before[key]] if key in before else before.values()):
        hint = (
            "" if key in before else f"; or, if on this kind of processor alone, write its {key} beside it, {digest!r}"
        )
        return f"{canary.name}: it does something else than the edition {canary.edition!r} did. {remedy}{hint}"
    return ""


def keep(found: Mapping[str, Canary]) -> None:
    """Write the digests of new things and new editions; those of an edition that is kept stay."""
    before = kept()
    now = {}
    for name, canary in found.items():
        old = before.get(name)
        same = old is not None and old["edition"] == canary.edition
        values = canary.values | (old["values"] if same else {})
        made = old if same else {"edition": canary.edition, processor_key(): canary.digest()}
        now[name] = made | {"values": values}
    lines = ",\n".join(f" {json.dumps(name)}: {json.dumps(now[name])}" for name in sorted(now))
    DIGESTS.write_text(f"{{\n{lines}\n}}\n")
