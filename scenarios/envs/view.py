"""Display of an env: the picture within a larger view, and a window."""

from __future__ import annotations

import os
from typing import Any

import cv2
import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenarios.loop import Loop
from sim.native_stderr import native_stderr_discarded

_SCALE = 1.6
_TRUE_RGB, _BELIEVED_RGB, _FRAME_RGB = (0, 114, 178), (230, 159, 0), (255, 255, 255)
_INSTALL = "pip install 'frameout[play]'"
_INVISIBLE = ("dummy", "offscreen")
"""SDL's drivers that show nothing; SDL falls back to them without a screen."""


def draw_view(loop: Loop, target: int) -> NDArray[np.uint8]:
    """Return the larger view (H, W, 3): white the observed frame, blue the target's true box, orange the estimate."""
    view = np.ascontiguousarray(loop.episode.larger_view(_SCALE))
    camera, truth = loop.frame.camera, loop.frame.truth
    margin = 0.5 * np.array([view.shape[1] - camera.width_px, view.shape[0] - camera.height_px])
    size = np.array([camera.width_px, camera.height_px])
    observed = np.concatenate([margin, margin + size]).astype(int)
    inside = (slice(observed[1], observed[3]), slice(observed[0], observed[2]))
    view[inside] = loop.frame.observation.image_rgb
    _rectangle(view, observed, _FRAME_RGB)
    _rectangle(view, truth.box_xyxy[target] + np.tile(margin, 2), _TRUE_RGB)
    draw_place(view, loop.estimate.position_px + margin)
    return view


def draw_place(picture: NDArray[np.uint8], place_px: ArrayLike) -> None:
    """Draw an estimate's place, an orange cross; nothing if it is not finite, or far away."""
    place = np.asarray(place_px, dtype=float)
    if np.isfinite(place).all() and (np.abs(place) < 1e5).all():
        cv2.drawMarker(picture, tuple(int(v) for v in np.rint(place)), _BELIEVED_RGB, cv2.MARKER_CROSS, 15, 2)


def _rectangle(view: NDArray[np.uint8], box_xyxy: NDArray[Any], colour: tuple[int, int, int]) -> None:
    if np.isfinite(box_xyxy).all() and (np.abs(box_xyxy) < 1e5).all():
        corners = [int(v) for v in np.rint(box_xyxy)]
        cv2.rectangle(view, (corners[0], corners[1]), (corners[2], corners[3]), colour, 1, cv2.LINE_AA)


def open_display(parameter: str) -> None:
    """Open pygame's display.

    A user may ask for invisible windows with SDL_VIDEODRIVER=dummy.

    Raises:
        ValueError: naming the parameter, if there is no screen, where SDL would open an invisible window.
    """
    import pygame

    try:
        # Without a screen it prints a line of its own.
        with native_stderr_discarded():
            pygame.display.init()
        driver = pygame.display.get_driver()
    except pygame.error as error:
        driver = str(error)
    seen = pygame.display.get_init() and driver not in _INVISIBLE
    if not seen and os.environ.get("SDL_VIDEODRIVER") != driver:
        pygame.display.quit()
        expected = "a screen to open a window on (SDL_VIDEODRIVER=dummy opens one that is not seen)"
        raise ValueError(f"{parameter}: expected {expected}, got none (SDL: {driver})")


class Window:
    """A window on the screen; needs pygame, an optional dependency."""

    def __init__(self, rate_hz: float) -> None:
        try:
            import pygame
        except ImportError:
            raise gym.error.DependencyNotInstalled(
                f"render_mode: expected pygame to be installed for 'human' ({_INSTALL}), got none"
            ) from None
        self._pygame = pygame
        self._rate_hz = rate_hz
        self._screen: Any = None
        open_display("render_mode")
        self._clock = pygame.time.Clock()

    def show(self, picture: NDArray[np.uint8]) -> None:
        """Show a picture (H, W, 3) and wait until it is due."""
        pygame = self._pygame
        size = (picture.shape[1], picture.shape[0])
        if self._screen is None or self._screen.get_size() != size:
            self._screen = pygame.display.set_mode(size)
        pygame.event.pump()
        self._screen.blit(pygame.surfarray.make_surface(picture.swapaxes(0, 1)), (0, 0))
        pygame.display.flip()
        self._clock.tick(self._rate_hz)

    def close(self) -> None:
        """Close the window."""
        self._pygame.display.quit()
