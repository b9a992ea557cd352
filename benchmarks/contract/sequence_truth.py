"""Truth of real sequences: what their files say of one target in a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.truth import Truth, truth_field


@dataclass(frozen=True, slots=True)
class SequenceTruth(Truth):
    """Truth of one frame of a real sequence. All that is in metres is NaN.

    ``state`` is ``in`` or ``partial`` (the border cuts it) where the target has a box; ``occluded`` where files say so,
    with a box if a part of it is seen; ``out`` where it is outside the picture, or has no box and no file says why.
    A frame of which no file tells anything is ``unlabelled``: it is shown to trackers and no score counts it.
    ``box_xyxy`` is NaN where the target is not seen, ``visible_fraction`` is 0 there and else NaN.

    Attributes:
        outside: (N,) whether files say that it is outside the picture; false where it may be hidden.
    """

    outside: NDArray[np.bool_] = truth_field("1", "N")
