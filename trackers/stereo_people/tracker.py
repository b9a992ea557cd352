"""``stereo_people``, our own: tracks all visible people by place in the frame of odometry, height and look."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre
from trackers.light_adaptive_stereo.candidates import CandidateParameters, candidate_in_box
from trackers.light_adaptive_stereo.light_change import camera_registers
from trackers.light_adaptive_stereo.matching import StereoMatcher, baseline_m
from trackers.light_adaptive_stereo.occlusion import OcclusionParameters, share_before
from trackers.light_adaptive_stereo.stereo_view import StereoView, first_mounting, see
from trackers.registry import register, register_variant, tunable
from trackers.stereo_people.look import log_levels
from trackers.stereo_people.scene import Scene, points_of_body
from trackers.stereo_people.tracks import Sighting, Track, TrackParameters, associate
from trackers.types import CameraRegisters, Estimate, Observation

_HIDDEN = 0.95
_LEAST_WANTED = -0.5
_GLIMPSE_S = 0.3
_APART_M = 0.8
_SURE_S, _UNDONE_S = 3.0, 0.7
_EXPECTED_S, _FAR_AWAY = 1.0, 8.0
_FRAME_MOST, _CLEARLY = 2.0, 8.0
"""Log-likelihood ratios that another track is the target: greatest of one frame, and sum at which it is accepted."""
_FULL_REGISTERS = np.array([1023.0, 1023.0])


@dataclass(frozen=True)
class StereoPeopleParameters:
    """Parameters of ``stereo_people``; the ``use_`` ones switch parts off, for ablation.

    Attributes:
        use_light: if False, the light is taken to be constant.
        use_odometry: if False, places are relative to the robot, as in the paper.
        use_others: if False, only the target is tracked.
        use_nearby: if False, a half-hidden person who is no candidate is not looked for.
        acceleration_mps2, look_weight: see ``TrackParameters``.
        register_weight: deviation of looks per change of the camera's red and blue gains, as shares of their range.
        recognised: log-likelihood ratio above which a person who comes into sight is the lost target.
        impatience_per_s: decrease of that threshold for every second after the first without the target.
        fastest_mps: greatest speed at which a lost target is expected to move.
        answered_m: standard deviation of a predicted place up to which it is answered.
        answered_s: time without a sighting up to which it is answered.
    """

    use_light: bool = True
    use_odometry: bool = True
    use_others: bool = True
    use_nearby: bool = True
    acceleration_mps2: float = tunable(1.5, 0.3, 5.0, log=True)
    look_weight: float = tunable(0.35, 0.05, 1.0, log=True)
    register_weight: float = tunable(3.0, 0.3, 10.0, log=True)
    recognised: float = tunable(1.0, -2.0, 8.0)
    impatience_per_s: float = tunable(0.6, 0.0, 2.0)
    fastest_mps: float = tunable(2.0, 1.0, 4.0)
    answered_m: float = tunable(0.3, 0.1, 0.6)
    answered_s: float = tunable(1.0, 0.2, 3.0)


@register(
    "stereo_people",
    role="ours",
    summary="stereo; tracks all people in the frame of odometry; appearance separate from light",
    suites=("stereo",),
)
class StereoPeople:
    """Tracks the target and all other visible people, so that none of these is mistaken for the target."""

    Parameters = StereoPeopleParameters

    def __init__(self, parameters: StereoPeopleParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._tracks_parameters = TrackParameters(
            acceleration_mps2=parameters.acceleration_mps2, look_weight=parameters.look_weight
        )
        self._candidates = CandidateParameters()
        self._occlusions = OcclusionParameters()
        self._matcher = StereoMatcher()

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the candidate in the box, or on the box itself if there is none."""
        p = self._parameters
        baseline_m(observation.camera)
        self._registers = camera_registers(observation)
        self._mounting = first_mounting(observation, box_xyxy, self._matcher, self._candidates.usual_height_m)
        self._time_s = observation.time_s
        self._scene = self._scene_of(observation, log_levels(self._matcher.smaller(observation.image_rgb)))
        view, self.elsewhere_cpu_s = see(observation, self._matcher, self._mounting, self._candidates)
        first = None if view is None else candidate_in_box(view.candidates, box_xyxy)
        if view is not None and first is not None:
            sighting = self._scene.whole(view, first)
        else:
            sighting = self._scene.in_box(box_xyxy)
        self._target = Track(sighting, self._time_s, self._tracks_parameters)
        self._others: list[Track] = []
        self._replaced: Track | None = None
        if view is not None and p.use_others:
            others = [self._scene.whole(view, candidate) for candidate in view.candidates if candidate is not first]
            self._others = [Track(sighting, self._time_s, self._tracks_parameters) for sighting in others]

    def update(self, observation: Observation) -> Estimate:
        """Take in the next pair; return the target's measured or predicted place."""
        registers = camera_registers(observation, self._registers)
        levels = log_levels(self._matcher.smaller(observation.image_rgb))
        self._predict(observation, registers, levels)
        self._registers, self._scene = registers, self._scene_of(observation, levels)
        view, self.elsewhere_cpu_s = see(observation, self._matcher, self._mounting, self._candidates)
        if view is not None:
            self._take_in(view)
        return self._answer(observation, view)

    def _predict(self, observation: Observation, registers: CameraRegisters, levels: NDArray[np.float64]) -> None:
        seconds, self._time_s = max(observation.time_s - self._time_s, 0.0), observation.time_s
        p = self._parameters
        shift, loosened = np.zeros(3), 0.0
        if p.use_light:
            # Most of a picture is walls and ground: its median changes with the light and the camera's settings alone.
            shift = np.median((levels - self._scene.levels).reshape(-1, 3), axis=0)
            change = np.array([registers.red - self._registers.red, registers.blue - self._registers.blue])
            loosened = p.register_weight * float(np.abs(change / _FULL_REGISTERS).sum())
        replaced = [] if self._replaced is None else [self._replaced]
        for track in (self._target, *replaced, *self._others):
            track.predict(seconds, shift, loosened)

    def _take_in(self, view: StereoView) -> None:
        sightings = [self._scene.whole(view, candidate) for candidate in view.candidates]
        # A target lost for long may be anywhere: its predicted place is no evidence any more.
        is_lost = self._unconfirmed_s() > self._parameters.answered_s
        found = associate(self._others if is_lost else [self._target, *self._others], sightings)
        found = [None, *found] if is_lost else found
        for track, index in zip((self._target, *self._others), found, strict=True):
            if index is not None:
                track.correct(sightings[index], self._time_s)
                if found[0] is not None and self._replaced is None and self._away_m(track.filter.place_m) > _APART_M:
                    track.count_beside()
        self._settle()
        if found[0] is None and self._parameters.use_nearby:
            taken = [view.candidates[index].pixels for index in found[1:] if index is not None]
            self._look_nearby(view, taken)
        if self._parameters.use_others:
            p = self._tracks_parameters
            self._others = [track for track in self._others if track.unseen_s <= p.kept_s]
            new = [s for k, s in enumerate(sightings) if k not in found]
            self._others += [Track(sighting, self._time_s, p) for sighting in new]
            if self._unconfirmed_s() > _GLIMPSE_S:
                self._recognise()
        elif found[0] is None:
            self._recognise_among(sightings)

    def _look_nearby(self, view: StereoView, taken: list[NDArray[np.int64]]) -> None:
        """Update the target with a visible part of the body at the expected place, though it is no candidate."""
        if self._unconfirmed_s() > self._parameters.answered_s:
            return
        expected_m = self._scene.to_robot(self._target.filter.place_m)
        pixels = points_of_body(view.points_m, expected_m, taken)
        if pixels is None:
            return
        sighting = self._scene.part(view, pixels, self._target.height_m)
        if self._target.score(sighting) > 0.0:
            self._target.correct_by_part(sighting)

    def _unconfirmed_s(self) -> float:
        """Return the time since the target was last seen whole."""
        return max(self._time_s - self._target.confirmed_s, 0.0)

    def _recognise(self) -> None:
        """Take another track for the lost target, if it looks like the target and is within reach."""
        scores = [
            (self._resemblance(track), track)
            for track in self._others
            if track.unseen_s == 0.0 and self._reachable(track.filter.place_m)
        ]
        if not scores:
            return
        best, track = max(scores, key=lambda pair: pair[0])
        if best > self._wanted():
            self._others.remove(track)
            self._switch_to(track)

    def _resemblance(self, track: Track) -> float:
        """Return the log-likelihood ratio that a track is the target, by place, look and height; after a second without
        the target by look and height alone.
        """
        score, unconfirmed_s = self._target.score(track.latest), self._unconfirmed_s()
        if not np.isfinite(score) or unconfirmed_s > _EXPECTED_S:
            score = self._target.appearance(track.latest) - _FAR_AWAY * (unconfirmed_s <= _EXPECTED_S)
        return score - track.other_evidence()

    def _switch_to(self, track: Track) -> None:
        """Make a track the target's, with the target's look; keep the lost track until the switch is confirmed."""
        lost = self._replaced or self._target
        track.continue_lost(lost)
        self._target, self._replaced, self._switched_at_s = track, lost, self._time_s
        for other in (track, *self._others):
            other.favour = 0.0

    def _settle(self) -> None:
        """Confirm the latest switch after three seconds; before, undo it if that track is lost, or switch again."""
        if self._replaced is None:
            return
        own = self._replaced.appearance(self._target.latest)
        for track in self._others:
            if track.unseen_s == 0.0:
                better = self._replaced.appearance(track.latest) - track.other_evidence() - own
                track.favour = max(track.favour + float(np.clip(better, -_FRAME_MOST, _FRAME_MOST)), -_CLEARLY)
        best = max(self._others, key=lambda track: track.favour, default=self._target)
        if best.favour > _CLEARLY:
            self._others[self._others.index(best)] = self._target
            self._switch_to(best)
        elif self._unconfirmed_s() > _UNDONE_S:
            self._target, self._replaced = self._replaced, None
        elif self._time_s - self._switched_at_s > _SURE_S:
            self._replaced = None

    def _away_m(self, place_m: NDArray[np.float64]) -> float:
        return float(np.hypot(*(place_m - self._target.filter.place_m)))

    def _recognise_among(self, sightings: list[Sighting]) -> None:
        reachable = [sighting for sighting in sightings if self._reachable(sighting.place_m)]
        scores = [self._target.appearance(sighting) for sighting in reachable]
        if scores and max(scores) > self._wanted():
            self._switch_to(Track(reachable[int(np.argmax(scores))], self._time_s, self._tracks_parameters))

    def _wanted(self) -> float:
        """Return the log-likelihood ratio required of a lost target; it falls with the time since the last sighting."""
        p = self._parameters
        return max(p.recognised - p.impatience_per_s * max(self._unconfirmed_s() - 1.0, 0.0), _LEAST_WANTED)

    def _reachable(self, place_m: NDArray[np.float64]) -> bool:
        return self._away_m(place_m) <= 0.7 + self._parameters.fastest_mps * self._unconfirmed_s()

    def _answer(self, observation: Observation, view: StereoView | None) -> Estimate:
        p, target = self._parameters, self._target
        place_m = self._scene.to_robot(target.filter.place_m)
        deviation_m = float(np.sqrt(np.linalg.eigvalsh(target.filter.P[:2, :2])[-1]))
        is_seen = target.unseen_s == 0.0
        is_expected = target.unseen_s <= p.answered_s and deviation_m <= p.answered_m
        height_m = target.height_m if np.isfinite(target.height_m) else self._candidates.usual_height_m
        camera = observation.camera
        box, depth_m = self._mounting.standing_box(place_m, self._candidates.usual_width_m, height_m, camera)
        if not (is_seen or is_expected) or depth_m <= 0.1:
            return Estimate(np.full(2, np.nan), in_view_probability=0.0)
        centre_px = box_centre(box)
        hidden = 0.0
        if view is not None and not is_seen:
            hidden = share_before(view.depth_m, place_m, height_m, 0.5, self._mounting, camera, self._occlusions)
        inside = 0.0 <= centre_px[0] < camera.width_px
        probability = 1.0 if is_seen else (0.9 if inside and hidden < _HIDDEN else 0.2)
        return Estimate(centre_px, box, in_view_probability=probability, depth_m=depth_m)

    def _scene_of(self, observation: Observation, levels: NDArray[np.float64]) -> Scene:
        look = self._tracks_parameters.look
        return Scene(observation, levels, self._mounting, self._candidates, look, self._parameters.use_odometry)


register_variant("stereo_people_no_light", of="stereo_people", summary="ours, without the light model", use_light=False)
register_variant("stereo_people_no_odometry", of="stereo_people", summary="ours, without odometry", use_odometry=False)
register_variant(
    "stereo_people_no_others", of="stereo_people", summary="ours, tracks the target only", use_others=False
)
register_variant(
    "stereo_people_no_nearby", of="stereo_people", summary="ours, without partial candidates", use_nearby=False
)
