"""A recording of tracks as an episode: it has no frame, and is judged by the gaps in its tracks."""

from __future__ import annotations

from typing import Any, NoReturn

from scenarios.scenario import Frame
from trackers.types import CameraCommand, CameraModel, Start


class TracksEpisode:
    """See ``scenarios.scenario.Episode``: one without pictures."""

    frame_count, rate_hz, closed_loop = 0, 1.0, False

    @property
    def start(self) -> Start:
        """See ``Episode``."""
        return Start(CameraModel(1, 1, 1.0))

    def step(self, command: CameraCommand | None = None) -> Frame:
        """See ``Episode``. There is no frame."""
        raise IndexError("a recording of tracks has no frame")

    def map_of(self) -> Any:
        """See ``Episode``. None is known."""
        return None

    def larger_view(self, scale: float) -> NoReturn:
        """See ``Episode``. There is no picture."""
        raise IndexError("a recording of tracks has no picture")

    def normals(self) -> NoReturn:
        """See ``Episode``. There is no picture."""
        raise IndexError("a recording of tracks has no picture")

    def close(self) -> None:
        """See ``Episode``. Nothing is open."""
