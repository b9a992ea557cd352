"""The scenario ``harbour-ptz-v1``: the harbour through the thermal zoom camera of a pan-tilt head on its mast.

Trackers get the pictures of the camera that is steered: a person who leaves them, or goes behind a car, is lost until
the head finds them again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scenarios.harbour.intruders import Intruders
from scenarios.harbour.layout import FIXED
from scenarios.harbour.presets import BY_SEED, SITES, Harbour
from scenarios.harbour.scenario import HarbourEpisode, day_of
from scenarios.harbour.truth import HarbourTruth
from scenarios.pan_tilt_zoom import Head, Mount
from scenarios.scenario import Scenario, Setup
from trackers.types import CameraModel, Carrier, CommandAxis, EgoPose, Observation

HEAD = Carrier(
    "harbour-ptz",
    (CommandAxis("pan_rad_s", 1.0, 4.0), CommandAxis("tilt_rad_s", 0.6, 3.0), CommandAxis("zoom_per_s", 0.7, 3.0)),
    "around",
)
"""Limits are those of a surveillance head; its lens zooms from one end to the other in 4 s."""
_WIDEST_RAD = float(np.deg2rad(25.0))
"""Width of the view at zoom 1: most of the site."""
MOUNT = Mount(
    HEAD,
    CameraModel.from_field_of_view(384, 288, _WIDEST_RAD, band="thermal"),
    place_m=FIXED.camera_m,
    aim_m=(0.0, 0.0, 0.0),
    ahead=(1.0, 0.0, 0.0),
    left=(0.0, 1.0, 0.0),
    widest_pan_rad=0.9,
    tilt_rad=(-0.9, 0.1),
    zoom=(1.0, 14.0),
    watches=True,
    step_rad=float(np.deg2rad(92.5714 / 3600.0)),
)
"""Its angles are read in steps of 92.6 seconds of arc, as in the manual of the FLIR PTU-D300 (4.3.3)."""
WIDEST_VIEW_M = 384 / 62.5
"""EN 62676-4:2015, level "observation" of video surveillance: 62.5 pixels to a metre, so that clothes and what someone
does are seen. In a picture 384 pixels wide a person of 1.75 m is 109 pixels tall.
"""
_FIRST_VIEW = 0.8
"""Width of the first view, as a share of the widest one that counts."""

PRESETS = {
    "standard": Harbour(
        "two minutes at five pictures a second: two people walk about, others come and go",
        frame_count=600,
        rate_hz=5.0,
        people=8,
        cars=3,
        boats=1,
        patrols=2,
        background=0,
    ),
    "quick": Harbour(
        "half a minute with a few people",
        frame_count=150,
        rate_hz=5.0,
        people=3,
        cars=1,
        boats=1,
        cars_before=0,
        patrols=1,
        background=0,
    ),
}
PRESETS |= {
    "sites": replace(
        PRESETS["standard"],
        summary="two minutes at any hour, at another harbour for each seed",
        site=BY_SEED,
        start_h=(0.0, 24.0),
    ),
    "swell": replace(
        PRESETS["standard"],
        summary="another harbour for each seed, with swell on which boats heave, roll and pitch",
        site=BY_SEED,
        start_h=(0.0, 24.0),
        cloud=SITES["swell"].cloud,
        wind_mps=SITES["swell"].wind_mps,
        swell_m=SITES["swell"].swell_m,
        swell_period_s=SITES["swell"].swell_period_s,
    ),
}


class HarbourPtzEpisode(HarbourEpisode):
    """See ``scenarios.scenario.Episode``. The first picture has the target in the middle."""

    def _head_before(self, setup: Setup, intruders: Intruders) -> Head:
        preset = setup.preset
        target = intruders.names.index(setup.scenario.target)
        middle_m = intruders.course[0, target, :3, 3] + (0.0, 0.0, 0.5 * intruders.size_m[target, 2])
        lens = CameraModel.from_field_of_view(preset.width_px, preset.height_px, _WIDEST_RAD, band="thermal")
        site, (ahead, left) = self._site, self._site.volume_axes
        mount = replace(
            MOUNT,
            lens=lens,
            place_m=site.camera_m,
            aim_m=tuple(middle_m.tolist()),
            ahead=(*ahead.tolist(), 0.0),
            left=(*left.tolist(), 0.0),
        )
        return Head(mount, preset.rate_hz, mount.zoom_for(_FIRST_VIEW * WIDEST_VIEW_M))

    def _ego(self) -> EgoPose:
        assert self._head is not None
        return self._measured(self._head.T_world_measured)

    def _empty_pictures(self) -> list[Observation]:
        return []


HARBOUR_PTZ = Scenario(
    id="harbour-ptz-v1",
    summary="a person in a harbour, through the thermal zoom camera of a pan-tilt head",
    start="the person's box in the first picture, the camera's zoom and its pose by encoders, the survey of the site",
    stage=HarbourPtzEpisode,
    presets=PRESETS,
    classes={kind: kind for kind in ("person", "car", "boat")},
    carrier=HEAD,
    truth=HarbourTruth,
    target="person-0",
    widest_view_m=WIDEST_VIEW_M,
    day_of=day_of,
)
