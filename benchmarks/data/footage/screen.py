"""A window for footage: a box is dragged on its first picture, and its overlay is shown while it is made."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.run.packages import check_packages
from benchmarks.show.video import marks
from scenarios.envs.view import open_display

_SHARE = 0.9
"""Of the screen that a window takes up at most."""
_LEAST_PX = 3
"""Sides of a box that is smaller are a slip of the hand."""
_ASK = "drag a box around the target; Escape ends"


class Screen:
    """A window on the screen."""

    def __init__(self, parameter: str) -> None:
        """Open the display. Raises ValueError, which names the parameter, if pygame or a screen is missing."""
        check_packages(["pygame"], "play")
        import pygame

        open_display(parameter)
        self._pygame = pygame
        pygame.display.set_caption("frameout track")
        self._window: Any = None
        self._zoom = 1.0

    def show(self, image_rgb: NDArray[np.uint8]) -> bool:
        """Show a picture (H, W, 3), smaller if need be; return False once the user closes the window."""
        pygame = self._pygame
        height, width = image_rgb.shape[:2]
        if self._window is None:
            wide, high = pygame.display.get_desktop_sizes()[0]
            self._zoom = min(1.0, _SHARE * wide / width, _SHARE * high / height)
            self._window = pygame.display.set_mode((round(width * self._zoom), round(height * self._zoom)))
        shown = cv2.resize(image_rgb, self._window.get_size(), interpolation=cv2.INTER_AREA)
        self._window.blit(pygame.surfarray.make_surface(shown.swapaxes(0, 1)), (0, 0))
        pygame.display.flip()
        return not any(self._ends(each) for each in pygame.event.get())

    def box_on(self, image_rgb: NDArray[np.uint8]) -> NDArray[np.float64] | None:
        """Let the user drag a box (4,) on a picture (H, W, 3); None if the window is closed instead."""
        pygame = self._pygame
        asking = image_rgb.copy()
        marks.draw_label(asking, (12, 28), _ASK, marks.INK, size=18)
        self.show(asking)
        begun: NDArray[np.float64] | None = None
        while True:
            event = pygame.event.wait()
            if self._ends(event):
                return None
            place = np.array(getattr(event, "pos", (0, 0))) / self._zoom
            if event.type == pygame.MOUSEBUTTONDOWN:
                begun = place
            elif begun is not None and event.type in (pygame.MOUSEMOTION, pygame.MOUSEBUTTONUP):
                box = np.concatenate([np.minimum(begun, place), np.maximum(begun, place)])
                if event.type == pygame.MOUSEBUTTONUP and (box[2:] - box[:2] >= _LEAST_PX).all():
                    return box
                drawn = asking.copy()
                marks.draw_box(drawn, box, marks.ESTIMATE)
                self.show(drawn)
                begun = None if event.type == pygame.MOUSEBUTTONUP else begun

    def _ends(self, event: Any) -> bool:
        pygame = self._pygame
        return event.type == pygame.QUIT or (event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE)

    def close(self) -> None:
        """Close the window."""
        self._pygame.display.quit()
