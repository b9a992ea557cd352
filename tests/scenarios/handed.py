"""All that trackers are handed in an episode, as bytes: pictures apart from what stands beside them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, NamedTuple

import numpy as np

from scenarios.scenario import Episode
from trackers.types import CameraCommand, Observation

FROM_PICTURES = ("image_rgb", "right_rgb", "counts", "settings")
"""Fields of an observation that a camera makes of what it sees; its exposure is one of them."""


class Handed(NamedTuple):
    """What an episode hands to a tracker.

    Attributes:
        start: calibration, box of the target, pictures of the background.
        pictures: of each frame. beside: of each frame, all but the pictures and the camera's own settings.
    """

    start: list[bytes]
    pictures: list[list[bytes]]
    beside: list[list[bytes]]


def assert_pictures_alone_change(own: Handed, other: Handed, changed_from: int) -> None:
    """Check two episodes whose targets differ from a frame on: nothing but their pictures does, from then on."""
    assert own.start == other.start
    assert own.beside == other.beside
    assert own.pictures[:changed_from] == other.pictures[:changed_from]
    assert own.pictures[changed_from:] != other.pictures[changed_from:]


def assert_found_out(own: Handed, other: Handed, changed_from: int) -> None:
    """Check two such episodes of a camera that knows its target: what stands beside the pictures tells."""
    assert own.beside[:changed_from] == other.beside[:changed_from]
    assert own.beside[changed_from:] != other.beside[changed_from:]


def assert_at_rest(seen: Handed) -> None:
    """Check that all that stands beside the pictures is the same on every frame, but for the time."""
    assert len({tuple(each[1:]) for each in seen.beside}) == 1
    assert len({each[0] for each in seen.beside}) == len(seen.beside)


def handed_by(episode: Episode, commands: Sequence[CameraCommand | None]) -> Handed:
    """Return what an episode hands out on as many frames as there are commands; the first one is not used."""
    start = list(_bytes_of(episode.start))
    seen = [episode.step(command if k else None).observation for k, command in enumerate(commands)]
    return Handed(start, [_fields_of(each, True) for each in seen], [_fields_of(each, False) for each in seen])


def _fields_of(observation: Observation, from_pictures: bool) -> list[bytes]:
    names = [field.name for field in fields(observation) if (field.name in FROM_PICTURES) == from_pictures]
    return [each for name in names for each in _bytes_of(getattr(observation, name))]


def _bytes_of(held: Any) -> Iterator[bytes]:
    if is_dataclass(held):
        for field in fields(held):
            yield from _bytes_of(getattr(held, field.name))
    elif isinstance(held, tuple):
        for each in held:
            yield from _bytes_of(each)
    else:
        yield b"none" if held is None else np.asarray(held).tobytes()
