# /// script
# dependencies = ["opencv-contrib-python-headless==5.0.0.93", "numpy==2.4.6"]
# ///
"""Trackers of OpenCV's contrib modules, with OpenCV's settings, e.g. CSRT (Lukežič et al., Discriminative correlation
filter with channel and spatial reliability, CVPR 2017) and KCF (Henriques et al., High-speed tracking with kernelized
correlation filters, PAMI 2015)::

    frameout bench frame-out --process kcf="opencv_contrib.py KCF"

They get pictures and the first box alone. The estimate is always inside the picture: where a tracker fails, the last
box stays, with an in-view probability of 0. A tracker is named as in ``cv2.TrackerNAME_create`` or, of the older ones,
``cv2.legacy``.
"""

import sys

import cv2
import numpy as np
from frameout_client import Estimate, serve

_LEAST_BOX_PX, _LEAST_PICTURE_PX = 5, 16
"""OpenCV does not terminate with boxes of 4 x 4; a smaller picture is not handed to it."""


def _of(name):
    found = [getattr(home, f"Tracker{name}_create", None) for home in (cv2, getattr(cv2, "legacy", None))]
    if not any(found):
        sys.exit(f"expected the name of a tracker of OpenCV {cv2.__version__}, e.g. CSRT or KCF, got {name!r}")
    return next(filter(None, found))


class OpenCvTracker:
    """One tracker, made anew for each target."""

    def __init__(self, parameters, rng):
        self._tracker = None

    def initialise(self, observation, box_xyxy):
        """Start on the part of the box inside the picture, in whole pixels."""
        size = np.array([observation.camera.width_px, observation.camera.height_px])
        low = np.clip(np.floor(box_xyxy[:2]), 0, size - _LEAST_BOX_PX)
        high = np.maximum(np.clip(np.ceil(box_xyxy[2:]), _LEAST_BOX_PX, size), low + _LEAST_BOX_PX)
        self._box_xyxy = np.concatenate([low, high])
        if size.min() >= _LEAST_PICTURE_PX:
            self._tracker = new_tracker()
            self._tracker.init(_bgr(observation), tuple(int(each) for each in (*low, *(high - low))))

    def update(self, observation):
        """Return the tracker's box, or the last one where it fails; NaN if the picture is too small for it."""
        if self._tracker is None:
            return Estimate(np.full(2, np.nan))
        found, (x, y, width, height) = self._tracker.update(_bgr(observation))
        found = found and width > 0 and height > 0
        if found:
            self._box_xyxy = np.array([x, y, x + width, y + height], dtype=float)
        centre_px = 0.5 * (self._box_xyxy[:2] + self._box_xyxy[2:])
        return Estimate(centre_px, self._box_xyxy.copy(), in_view_probability=float(found))


def _bgr(observation):
    return np.ascontiguousarray(observation.image_rgb[..., ::-1])


if __name__ == "__main__":
    cv2.setNumThreads(1)
    new_tracker = _of(sys.argv[1] if len(sys.argv) > 1 else "")
    serve(OpenCvTracker)
