"""Recent changes of the light, from truth; results are grouped by them."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from scenarios.stereo_follow.camera import SENSOR
from scenarios.stereo_follow.light_plan import NEW_S
from scenarios.stereo_follow.truth import LightEvent
from sim.sensors.config import Picture
from sim.shaders.colour import LUMINANCE_WEIGHTS, srgb_to_linear

_LINEAR = srgb_to_linear(np.arange(256) / 255.0)
_BACK_LIGHT = 3.0
"""Threshold of back light: mean luminance of the picture over that of a grey coat on the target's back."""
_COAT = 0.3
"""Reflectance of the grey coat."""
_SHADE = 0.4
"""Threshold of shade: share of the highest illuminance within the last second."""
_STEP_PX = 8


class LightEvents:
    """Detects new changes of the light; of several, the first of these counts.

    They are: a switched lamp; the target at a door, in the light of two places; the start of back light; shade, a fall
    of the light on the target below two fifths within a second. Each is new for a second.
    """

    def __init__(self, places: Sequence[str], switched: Sequence[LightEvent | None], rate_hz: float) -> None:
        """``places`` (F,) are the target's places; ``switched`` (F,) are the lamp events there, see ``LightPlan``."""
        self._places, self._switched = places, switched
        self._new_frames = int(NEW_S * rate_hz)
        self._illuminance_lx: deque[float] = deque(maxlen=self._new_frames)
        self._was_back_lit = False
        self._latest: LightEvent | None = None
        self._since = self._new_frames

    def follow(self, frame: int, picture: Picture, illuminance_lx: float) -> LightEvent | None:
        """Add a frame; return ``PeopleTruth.light_event``.

        Args:
            illuminance_lx: on the target, towards the camera.
        """
        is_back_lit = _luminance_nit(picture) > _BACK_LIGHT * _COAT * illuminance_lx / np.pi
        begins: LightEvent | None = None
        if frame > 0 and "door" in (self._places[frame], self._places[frame - 1]):
            begins = "doorway"
        elif is_back_lit and not self._was_back_lit and frame > 0:
            begins = "back light"
        elif self._illuminance_lx and illuminance_lx < _SHADE * max(self._illuminance_lx):
            begins = "shade"
        self._was_back_lit = bool(is_back_lit)
        self._illuminance_lx.append(illuminance_lx)
        self._since += 1
        switched = self._switched[frame]
        if switched is not None:
            # A lamp also causes other changes; they do not count as events, during it or after it.
            self._latest, self._since = None, self._new_frames
            self._illuminance_lx.clear()
            return switched
        if begins is not None and (begins != self._latest or self._since >= self._new_frames):
            self._latest, self._since = begins, 0
        return self._latest if self._since < self._new_frames else None


def _luminance_nit(picture: Picture) -> float:
    """Return the mean luminance of a picture; white pixels may be brighter."""
    # Luminances first: averaging three colours over both axes takes twice as long.
    level = float((_LINEAR[picture.image_rgb[::_STEP_PX, ::_STEP_PX]] @ LUMINANCE_WEIGHTS).mean())
    used = picture.settings
    return level * SENSOR.full_well_e / (SENSOR.electrons_per_nit_s * used.exposure_s * used.gain)
