"""The survey of presets: frame-outs, their lengths, and turns and excursions during them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from scenarios.road_town.pilot import OUT, frame_out_spans, picture_states
from scenarios.road_town.plan import TARGET, make_plan
from scenarios.road_town.presets import RoadTown
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.scenario import ROAD_TOWN, ROAD_TOWN_NEXT
from sim.checks import check
from sim.rng import episode_seed


@dataclass(frozen=True)
class Held:
    """Contents of one preset's episodes on their set paths.

    Attributes:
        episodes: number of episodes.
        frames: frames per episode.
        frame_outs_mean, frame_outs_minimum: number per episode.
        length_frames_minimum, length_frames_median, length_frames_maximum: of a frame-out.
        share_turning, share_off_road: share of frame-outs during which the target turns at a crossing, or is off the
            road.
        share_never_back: share of frame-outs that last until the episode's end.
        share_of_frames_outside: of all frames.
    """

    episodes: int
    frames: int
    frame_outs_mean: float
    frame_outs_minimum: int
    length_frames_minimum: int
    length_frames_median: float
    length_frames_maximum: int
    share_turning: float
    share_off_road: float
    share_never_back: float
    share_of_frames_outside: float


@dataclass(frozen=True)
class FrameOutSurvey:
    """See ``scenarios.scenario.Survey``.

    Attributes:
        scenario: catalogue id, from which the seeds follow.
    """

    scenario: str

    columns = (
        "frame-outs\nan episode",
        "frames outside,\nmin / median / max",
        "with a\nturn",
        "off the\nroad",
        "never\nback",
    )

    def measure(self, preset: RoadTown, seeds: range) -> dict[str, Any]:
        """Return the fields of ``Held``."""
        return asdict(_held(preset, self.scenario, seeds))

    def cells(self, held: dict[str, Any]) -> tuple[str, ...]:
        """See ``Survey``."""
        lengths = (held["length_frames_minimum"], held["length_frames_median"], held["length_frames_maximum"])
        return (
            f"{held['frame_outs_mean']:.1f} (≥ {held['frame_outs_minimum']})",
            " / ".join(f"{length:g}" for length in lengths),
            f"{held['share_turning']:.0%}",
            f"{held['share_off_road']:.0%}",
            f"{held['share_never_back']:.0%}",
        )


FRAME_OUTS, FRAME_OUTS_NEXT = FrameOutSurvey(ROAD_TOWN.id), FrameOutSurvey(ROAD_TOWN_NEXT.id)


def _held(preset: RoadTown, scenario: str, seeds: range) -> Held:
    counts, lengths, turning, off_road, never_back, outside = [], [], [], [], [], []
    for seed in seeds:
        plan = make_plan(preset, episode_seed(seed, scenario, 0), closed_loop=False)
        states = picture_states(plan.camera, plan.camera_poses, plan.target_corners_m())
        on_road = RoadMap(plan.layout.graph).is_on_road(plan.motion.position_m[:, TARGET])
        spans = frame_out_spans(states)
        counts.append(len(spans))
        outside.append(float((states == OUT).mean()))
        for start, end in spans:
            lengths.append(end - start)
            turning.append(any(plan.turning(frame) for frame in range(start, end)))
            off_road.append(not on_road[start:end].all())
            never_back.append(end == preset.frame_count)
    check("seeds", bool(lengths), "one at least of an episode with a frame-out", seeds)
    return Held(
        episodes=len(seeds),
        frames=preset.frame_count,
        frame_outs_mean=float(np.mean(counts)),
        frame_outs_minimum=int(np.min(counts)),
        length_frames_minimum=int(np.min(lengths)),
        length_frames_median=float(np.median(lengths)),
        length_frames_maximum=int(np.max(lengths)),
        share_turning=float(np.mean(turning)),
        share_off_road=float(np.mean(off_road)),
        share_never_back=float(np.mean(never_back)),
        share_of_frames_outside=float(np.mean(outside)),
    )
