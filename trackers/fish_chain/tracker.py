"""``shoal_chain``, our own: tracklets of fish, linked by motion and looks, with gaps bridged.

Answers are given at once and, with hindsight, again after the video.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.fish_chain.detection import Detector, DetectorParameters
from trackers.fish_chain.fish import Fish, measured, predicted
from trackers.fish_chain.linking import IMPOSSIBLE, Appearance, Match, MotionModel, MotionParameters, Starts, best_links
from trackers.fish_chain.tracklets import Tracklet, TrackletBuilder, TrackletParameters
from trackers.gaps import GapMethod, Surroundings
from trackers.registry import register, register_variant, tunable
from trackers.swimmer.method import SwimGaps
from trackers.types import CameraModel, Observation, Track

_FIRST_LESSON = 30
"""Frames after which the models learn for the first time; then whenever the number has grown by half."""
_LESSON_FRAMES = 5
"""Length of the shortest tracklet that is learnt from."""
_LEAST_FRAMES = 3
"""Shorter tracklets are taken for glints."""
_COUNTED_FRAMES = 15
"""Frames for which so many fish must be seen at the same time to be counted, and of a fish that counts."""
_ROUNDS = (0.999, 0.99, 0.9)
"""Offline, sure links come first: their fish show more of their looks to the others."""


@dataclass(frozen=True)
class ChainParameters(DetectorParameters, TrackletParameters, MotionParameters):
    """Parameters of ``Chain``.

    Attributes:
        use_motion, use_appearance, use_posture: if False, links are decided without.
        trust: factor on the log-likelihood ratio of looks; below 1, as features are not independent.
        known: log-odds that a tracklet continues another one, before place and looks are known.
        complete: added to them when all fish that were ever seen together have names.
        made: probability from which on a link is made.
        most_lost: frames of the longest gap that is bridged.
        delay: frames after which links and answers are final; offline they all are decided after the last picture.
        least_certainty: probability of a place within half a body from which on a fish that is not seen is answered.
    """

    use_motion: bool = True
    use_appearance: bool = True
    trust: float = tunable(0.7, 0.2, 1.5)
    known: float = tunable(2.0, -2.0, 8.0)
    complete: float = tunable(3.0, 0.0, 10.0)
    made: float = tunable(0.5, 0.0, 0.99)
    most_lost: int = 200
    delay: int = 30
    offline: bool = False
    least_certainty: float = tunable(0.5, 0.1, 0.95)


@dataclass(frozen=True, slots=True)
class Link:
    """A gap between two tracklets, and whether they were taken for one fish.

    Attributes:
        last_frame, last_px: where the first tracklet was seen last. next_frame, next_px: where the second begins.
        probability: that both are one fish. made: whether they were linked.
    """

    last_frame: int
    last_px: NDArray[np.float64]
    next_frame: int
    next_px: NDArray[np.float64]
    probability: float
    made: bool


class Chain:
    """Tracks all fish of a tank.

    Attributes:
        links: all decided so far, the abstentions too, in order of the decisions.
    """

    def __init__(self, parameters: ChainParameters, gap_method: GapMethod) -> None:
        self._parameters = parameters
        self._gap_method = gap_method
        self._begin(())

    def _begin(self, background: Sequence[Observation]) -> None:
        p = self._parameters
        self._detector = Detector(p)
        self._detector.start(background)
        self._builder = TrackletBuilder(p)
        self._appearance = Appearance()
        self._motion = MotionModel(p, self._gap_method)
        self._frame = -1
        self._lesson = _FIRST_LESSON
        self._pending: list[Tracklet] = []
        self._tracklets: list[Tracklet] = []
        self._guesses: dict[int, tuple[Tracklet, float]] = {}
        self._fish: dict[int, Fish] = {}
        self._seen_together: deque[int] = deque(maxlen=_COUNTED_FRAMES)
        self._settled: list[list[Track]] = []
        self._count = 0
        self._times_s: list[float] = []
        self._bounds = np.array([np.inf, np.inf, -np.inf, -np.inf])
        self.links: list[Link] = []

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self._begin(background)

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``; the newest links may be decided otherwise later, see ``revised``."""
        self._frame += 1
        self._times_s.append(observation.time_s)
        detections = self._detector.detect(observation)
        for each in detections:
            self._bounds[:2] = np.minimum(self._bounds[:2], each.position_px)
            self._bounds[2:] = np.maximum(self._bounds[2:], each.position_px)
        before = len(self._builder.ended)
        begun = self._builder.step(self._frame, detections, self._detector.body_px)
        self._tracklets += begun
        self._pending += begun
        self._count_fish()
        if self._frame + 1 >= self._lesson:
            self._learn()
            self._lesson = 3 * self._lesson // 2
        ripe = self._frame - self._parameters.delay
        changed = begun or len(self._builder.ended) > before
        if changed or any(each.first_frame <= ripe for each in self._pending):
            self._decide(self._parameters.delay)
        if ripe >= 0 and not self._parameters.offline:
            self._settled.append(self._answers(ripe, self._fish.values()))
        return self._now()

    def revised(self) -> list[list[Track]]:
        """Return the answers on all pictures, as decided within the delay, or offline with all of the video."""
        if self._parameters.offline:
            self._learn()
            fish = self._decide_all()
            # Guesses from while the pictures came need not agree with what is decided now.
            self._guesses = {}
        else:
            self._decide(0)
            fish = list(self._fish.values())
        latest = range(len(self._settled), self._frame + 1)
        return [*self._settled, *(self._answers(frame, fish) for frame in latest)]

    def _answers(self, frame: int, fish: Iterable[Fish]) -> list[Track]:
        """Return the tracks on a frame, with what is known by now."""
        p = self._parameters
        begun = {each.number: each for each in self._pending}
        likely = {
            tail.number: (begun[start], probability)
            for start, (tail, probability) in self._guesses.items()
            if start in begun and probability >= p.made
        }
        lasting = (each for each in fish if len(each) >= _LESSON_FRAMES)
        tracks = (each.on(frame, self._motion, p.least_certainty, likely.get(each.tail.number)) for each in lasting)
        return [track for track in tracks if track is not None]

    def _count_fish(self) -> None:
        """Learn how many fish there are: the most that were seen together, for some frames."""
        lasting = [each for each in self._builder.active if len(each) >= _COUNTED_FRAMES]
        self._seen_together.append(len(lasting) + len(self._builder.ghosts))
        if len(self._seen_together) == _COUNTED_FRAMES:
            self._count = max(self._count, min(self._seen_together))

    def _learn(self) -> None:
        long = [each for each in self._tracklets if len(each) >= _LESSON_FRAMES]
        self._appearance.learn([each.looks() for each in long])
        steps_s = np.diff(self._times_s)
        self._motion.interval_s = max(float(np.median(steps_s)), 1e-3) if len(steps_s) else 1 / 30
        self._motion.length_px = self._detector.body_px
        if np.isfinite(self._bounds).all():
            self._motion.around = Surroundings(self._bounds.copy())
        self._motion.learn([each.piece(self._motion.interval_s) for each in long])

    def _decide(self, delay: int) -> None:
        """Find the best links of all tracklets that are not decided, and decide those that began ``delay`` ago."""
        active = {each.number for each in self._builder.active}
        self._pending = [each for each in self._pending if each.number in active or len(each) >= _LEAST_FRAMES]
        if not self._pending:
            return
        oldest = self._frame - self._parameters.most_lost - self._parameters.delay
        tails = [Fish([each]) for each in self._pending] + list(self._fish.values())
        tails = [each for each in tails if each.tail.number not in active and each.tail.end_frame >= oldest]
        starts = [Fish([each]) for each in self._pending]
        matches = {match.start: match for match in best_links(self._costs(tails, starts, len(self._fish)))}
        self._guesses = {
            self._pending[start].number: (tails[match.tail].tail, match.probability) for start, match in matches.items()
        }
        owners = {each.tail.number: each for each in self._fish.values()}
        ripe = [k for k, each in enumerate(self._pending) if self._frame - each.first_frame >= delay]
        for start in sorted(ripe, key=lambda k: self._pending[k].first_frame):
            tracklet, match = self._pending[start], matches.get(start)
            owner = self._joined(owners, tails, tracklet, match)
            owners[tracklet.number] = owner
        decided = {self._pending[k].number for k in ripe}
        self._pending = [each for each in self._pending if each.number not in decided]

    def _joined(self, owners: dict[int, Fish], tails: Sequence[Fish], tracklet: Tracklet, match: Match | None) -> Fish:
        """Append a tracklet to the fish that it continues, or begin a new one, and return it."""
        fish = Fish([tracklet])
        if match is not None and self._is_made(tails[match.tail].tail, tracklet, match.probability):
            owner = owners[tails[match.tail].tail.number]
            owner.join(fish, match.probability)
            return owner
        self._fish[fish.identity] = fish
        return fish

    def _is_made(self, tail: Tracklet, start: Tracklet, probability: float) -> bool:
        made = probability >= self._parameters.made
        first_px = start.line_px(start.first_frame)
        self.links.append(
            Link(
                tail.end_frame - 1, tail.position_px, start.first_frame, first_px[len(first_px) // 2], probability, made
            )
        )
        return made

    def _decide_all(self) -> list[Fish]:
        """Link all tracklets of the video, the surest links first."""
        fish = [Fish([each]) for each in self._tracklets if len(each) >= _LEAST_FRAMES]
        self.links = []
        for limit in (*_ROUNDS, self._parameters.made):
            matches = best_links(self._costs(fish, fish, len(fish)))
            follower = {match.tail: match for match in matches if match.probability >= limit}
            joined = set()
            # From the last to the first, so that what is appended is complete.
            for tail in sorted(follower, key=lambda k: -fish[k].tail.end_frame):
                match = follower[tail]
                self._is_made(fish[tail].tail, fish[match.start].pieces[0], match.probability)
                fish[tail].join(fish[match.start], match.probability)
                joined.add(match.start)
            fish = [each for k, each in enumerate(fish) if k not in joined]
        for match in best_links(self._costs(fish, fish, len(fish))):
            self._is_made(fish[match.tail].tail, fish[match.start].pieces[0], match.probability)
        return fish

    def _costs(self, tails: Sequence[Fish], starts: Sequence[Fish], named: int) -> NDArray[np.float64]:
        """Return the costs (N, M) of starts as continuations of tails, for ``best_links``."""
        p = self._parameters
        costs = np.full((len(tails), len(starts)), IMPOSSIBLE)
        if not tails or not starts:
            return costs
        first = Starts.of([each.pieces[0] for each in starts])
        ends = np.array([each.tail.end_frame for each in tails])
        lost = first.first_frame[None] - ends[:, None]
        possible = (lost >= 0) & (lost <= p.most_lost)
        log_odds = np.full(costs.shape, p.known + (p.complete if 0 < self._count <= named else 0.0))
        if p.use_appearance:
            looks = ([each.looks() for each in fish] for fish in (tails, starts))
            log_odds += p.trust * self._appearance.log_ratios(*looks)
        if p.use_motion:
            for row in np.flatnonzero(possible.any(axis=1)).tolist():
                columns = np.flatnonzero(possible[row])
                chosen = Starts(first.first_frame[columns], first.place_px[columns], first.heading_rad[columns])
                log_odds[row, columns] += self._motion.log_ratios(tails[row].tail, chosen)
        return np.where(possible, -log_odds, IMPOSSIBLE)

    def _now(self) -> list[Track]:
        """Return the answer on the last picture with the names as they are known by now."""
        tracks, named = [], set()
        owners = {each.tail.number: each.identity for each in self._fish.values()}
        for each in self._builder.active:
            identity, probability = self._name(each, owners)
            named.add(identity)
            line, box = each.line_px(self._frame), each.box_xyxy(self._frame)
            tracks.append(measured(identity, line, box, probability))
        for each in self._builder.ghosts:
            identity, probability = self._name(each, owners)
            if identity not in named and self._frame in each.ghosts:
                named.add(identity)
                covariance = self._motion.followed(self._frame - each.end_frame)
                place = each.ghosts[self._frame][:2]
                tracks.append(
                    predicted(identity, each, self._frame, place, covariance, probability, self._motion.length_px)
                )
        return tracks

    def _name(self, tracklet: Tracklet, owners: dict[int, int]) -> tuple[int, float]:
        """Return the name of a tracklet's fish and the probability of the links that are not final yet."""
        probability = 1.0
        while tracklet.number not in owners and tracklet.number in self._guesses:
            tail, link = self._guesses[tracklet.number]
            if link < self._parameters.made:
                break
            tracklet, probability = tail, probability * link
        return owners.get(tracklet.number, tracklet.number), probability


@dataclass(frozen=True)
class ShoalChainParameters(ChainParameters):
    """Parameters of ``shoal_chain``.

    Attributes:
        learns: if False, gaps are bridged with the shipped weights, which learn nothing from the tracks at hand.
    """

    learns: bool = True


@register(
    "shoal_chain",
    role="ours",
    summary="detection and posture, tracklets, links by motion and looks within 30 frames",
    suites=("fish",),
)
class ShoalChain(Chain):
    """A ``RevisingTracker`` and ``BridgingTracker`` of all fish in a tank."""

    Parameters = ShoalChainParameters

    def __init__(self, parameters: ShoalChainParameters, rng: np.random.Generator) -> None:
        # The chain's own one learns from this video; the other one is taught by those that use it.
        own, self.gap_method = (SwimGaps(parameters.use_posture, learns=parameters.learns) for _ in range(2))
        super().__init__(parameters, own)


register_variant("shoal_chain_offline", "shoal_chain", summary="links decided after the whole video", offline=True)
register_variant("shoal_chain_shipped", "shoal_chain", summary="gaps bridged as shipped, nothing learnt", learns=False)
register_variant("shoal_chain_no_looks", "shoal_chain", summary="links without appearance", use_appearance=False)
register_variant("shoal_chain_no_motion", "shoal_chain", summary="links by appearance alone", use_motion=False)
register_variant("shoal_chain_no_posture", "shoal_chain", summary="links without posture", use_posture=False)
register_variant(
    "shoal_chain_motion",
    "shoal_chain",
    summary="links by places alone: neither looks nor posture",
    use_appearance=False,
    use_posture=False,
)
