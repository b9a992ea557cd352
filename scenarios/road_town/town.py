"""First, plain version, so that episodes can be lived through; the town helper replaces it."""

from __future__ import annotations

import cv2
import numpy as np
