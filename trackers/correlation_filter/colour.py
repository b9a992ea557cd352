"""How likely the samples of a patch belong to the target, by its colours and those around it.

Source: Bertinetto, Valmadre, Golodetz, Miksik, Torr, Staple: complementary learners for real-time tracking, CVPR 2016,
section 3.4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_LEVELS = 16
"""Of red, green and blue."""
_BINS = _LEVELS**3
_REGULARISATION = 1e-3


def colour_bins(patch_rgb: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Return the bin (H, W) of the colour of each sample of a patch (H, W, 3)."""
    red, green, blue = np.moveaxis(patch_rgb.astype(np.uint16) // (256 // _LEVELS), -1, 0)
    return (red * np.uint16(_LEVELS) + green) * np.uint16(_LEVELS) + blue


class ColourModel:
    """Histograms of colours on the target and around it, which follow both."""

    def __init__(self) -> None:
        self._on, self._around = np.zeros((2, _BINS))
        self._likelihood = np.zeros(_BINS, np.float32)

    def learn(self, on: NDArray[np.uint16], around: NDArray[np.uint16], rate: float) -> None:
        """Learn bins (any number) of samples on the target and around it, at a rate in [0, 1]; 1 forgets the others."""
        for histogram, bins in ((self._on, on), (self._around, around)):
            histogram += rate * (np.bincount(bins, minlength=_BINS) / max(bins.size, 1) - histogram)
        # The optimum of ridge regression on 1 for samples of the target and 0 for those around it.
        self._likelihood = (self._on / (self._on + self._around + _REGULARISATION)).astype(np.float32)

    def likelihood(self, bins: NDArray[np.uint16]) -> NDArray[np.float32]:
        """Return for bins of any shape how likely a sample belongs to the target, 0 to 1."""
        return self._likelihood[bins]
