"""What a data set is of: the episodes and channels that it holds, and what made them."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Literal

from benchmarks.data.sets.channels import CODINGS, channels_of, value_of
from scenarios import catalog
from scenarios.scenario import Episode, RendererName
from sim.checks import check

FORMAT = 3
"""Number of the layout of files and tables; increment it with every change."""
_READ_TOO = (2,)
"""Earlier formats that are read: 2 has no objects that stand about, and no bounds."""

OnError = Literal["stop", "skip"]
"""What becomes of the others at an episode that cannot be built."""


@dataclass(frozen=True)
class Request:
    """A data set as it is ordered.

    Attributes:
        scenario: catalogue id with its version. preset: name.
        seeds: first and last + 1 of the episodes.
        channels: stored for each frame, see ``channels_of``.
        pictures: coding of pictures, see ``CODINGS``.
        renderer: which one draws.
        size_px: width and height in place of the preset's. rate_hz, frame_count: likewise.
        scene: its edition, see ``benchmarks.run.editions``. packages: name -> version of what its bytes depend on.
    """

    scenario: str
    preset: str
    seeds: tuple[int, int]
    channels: tuple[str, ...]
    pictures: str = "blosc2"
    renderer: RendererName = "raster"
    size_px: tuple[int, int] | None = None
    rate_hz: float | None = None
    frame_count: int | None = None
    scene: str = ""
    packages: dict[str, str] = field(default_factory=dict)
    format: int = FORMAT

    def __post_init__(self) -> None:
        """Raise ValueError for a value that is not possible."""
        scenario = catalog.scenario(self.scenario)
        known = channels_of(scenario)
        for channel in self.channels:
            check("channels", channel in known, f"some of {', '.join(known)}", repr(channel))
        check("pictures", self.pictures in CODINGS, f"one of {', '.join(CODINGS)}", repr(self.pictures))
        check("seeds", 0 <= self.seeds[0] < self.seeds[1], "A:B with 0 <= A < B", ":".join(map(str, self.seeds)))
        self.configuration()

    def configuration(self, seed: int | None = None) -> Any:
        """Return the preset with the changes asked for, as in the episode of a seed, None = the first one.

        Raises:
            ValueError: for changes that it cannot take.
        """
        preset = catalog.scenario(self.scenario).configuration(self.preset, self.seeds[0] if seed is None else seed)
        width_px, height_px = self.size_px or (None, None)
        wanted = {
            "width_px": width_px,
            "height_px": height_px,
            "rate_hz": self.rate_hz,
            "frame_count": self.frame_count,
        }
        changes = {name: value for name, value in wanted.items() if value is not None}
        for name, value in changes.items():
            check(name, hasattr(preset, name), f"nothing, since {self.preset} of {self.scenario} sets it", value)
        return dataclasses.replace(preset, **changes)

    def episode(self, seed: int) -> Episode:
        """Build an episode of the data set, with all truth. Raises ValueError if a controller has to steer it."""
        with of_seed(seed):
            preset = self.configuration(seed)
        check("preset", not preset.closed_loop, "one on a set path or at rest", f"{self.preset!r}, in closed loop")
        with of_seed(seed):
            return catalog.scenario(self.scenario).episode(preset, seed, renderer=self.renderer)

    def as_json(self) -> str:
        """Return it as JSON."""
        return json.dumps(dataclasses.asdict(self), indent=1) + "\n"


@contextmanager
def of_seed(seed: int) -> Iterator[None]:
    """Name the seed in what its episode raises."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"seed {seed}: {error}") from error
    except Exception as error:
        error.add_note(f"of seed {seed}")
        raise


def request_of(content: bytes | str, where: str) -> Request:
    """Return the request of a data set's ``dataset.json``. Raises ValueError if it is none, or of another format."""
    try:
        values = json.loads(content)
        version = values["format"]
        check(where, version in (FORMAT, *_READ_TOO), f"a data set of format {FORMAT}", f"format {version}")
        values = {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}
        return Request(**values)
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        raise ValueError(f"{where}: expected the description of a data set, got {error}") from None


def first_episode(request: Request, on_error: OnError = "stop") -> Episode:
    """Build the first episode; with ``skip`` the first that can be built. Raises what the last one tried raises."""
    *others, last = range(*request.seeds) if on_error == "skip" else request.seeds[:1]
    for seed in others:
        try:
            return request.episode(seed)
        except OSError:
            # Of the disk, not of the episode.
            raise
        except Exception:
            continue
    return request.episode(last)


def existing_channels(request: Request, on_error: OnError = "stop") -> tuple[str, ...]:
    """Return the channels that the first frame of the ``first_episode`` has; both of a pair, if one was lost."""
    live = first_episode(request, on_error)
    try:
        first = live.step()
        known = channels_of(catalog.scenario(request.scenario))
        paired = {"right_rgb"} if first.observation.camera.baseline_m is not None else set()
        has = (channel in paired or value_of(first, channel, live.normals) is not None for channel in known)
        return tuple(channel for channel, there in zip(known, has, strict=True) if there)
    finally:
        live.close()
