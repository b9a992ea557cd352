"""What of the light has just changed, by truth: the words that results are divided by."""

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
"""Mean luminance of the picture, in units of that of a grey coat (reflectance 0.3) on the target's back."""
_COAT = 0.3
_SHADE = 0.4
"""Of the illuminance a second before."""
_STEP_PX = 8


class LightEvents:
    """Says on each frame which change of the light is new, the most particular first.

    Lamps that are switched; the target about a door (light of two places); back light that begins; shade: the light on
    the target falls below two fifths within a second. Each counts as new for a second.
    """

    def __init__(self, places: Sequence[str], switched: Sequence[LightEvent | None], rate_hz: float) -> None:
        """Know beforehand where the target is on each frame, and what is switched about it within the last second."""
        self._places, self._switched = places, switched
        self._new_frames = int(NEW_S * rate_hz)
        self._illuminance_lx: deque[float] = deque(maxlen=self._new_frames)
        self._was_back_lit = False
        self._latest: LightEvent | None = None
        self._since = self._new_frames

    def follow(self, frame: int, picture: Picture, illuminance_lx: float) -> LightEvent | None:
        """Take in a frame; return ``PeopleTruth.light_event``.

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
            # What follows from the lamp is the lamp's: nothing else begins by it, nor after it.
            self._latest, self._since = None, self._new_frames
            self._illuminance_lx.clear()
            return switched
        if begins is not None and (begins != self._latest or self._since >= self._new_frames):
            self._latest, self._since = begins, 0
        return self._latest if self._since < self._new_frames else None


def _luminance_nit(picture: Picture) -> float:
    """Return the mean luminance that a picture shows; what is white may be brighter."""
    # Luminances first: a mean over two axes of three colours takes twice as long.
    level = float((_LINEAR[picture.image_rgb[::_STEP_PX, ::_STEP_PX]] @ LUMINANCE_WEIGHTS).mean())
    used = picture.settings
    return level * SENSOR.full_well_e / (SENSOR.electrons_per_nit_s * used.exposure_s * used.gain)
