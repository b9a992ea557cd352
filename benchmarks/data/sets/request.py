"""What a data set is of: the episodes and channels that it holds, and what made them."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any, Literal

from benchmarks.contract.rows import TEST_SPLIT
from benchmarks.data.sets.channels import channels_of, check_pictures, value_of
from scenarios import catalog
from scenarios.field_values import is_number, with_values
from scenarios.scenario import Episode, RendererName
from sim.checks import check, check_choice

FORMAT = 4
"""Number of the layout of files and tables; increment it with every change."""
_READ_TOO = (2, 3)
"""Earlier formats that are read: 2 has no objects that stand about, and no bounds; up to 3 the list of files is JSON,
size, rate and number of frames stand beside the preset's name, and each episode has background pictures of its own.
"""
SPLITS = ("train", "val", "test")
_TURN, _TURNS = 0x9E3779B97F4A7C15, 2**64
"""The golden ratio as a share of ``_TURNS``: multiples of it, modulo 1, are spread evenly, wherever one begins."""

OnError = Literal["stop", "skip"]
"""What becomes of the others at an episode that cannot be built."""


@dataclass(frozen=True)
class Request:
    """A data set as it is ordered.

    Attributes:
        scenario: catalogue id with its version.
        preset: name, which may change values: ``quick[frame_count=20,traffic_cars=4:24]``.
        seeds: first and last + 1 of the episodes.
        channels: stored for each frame, see ``channels_of``.
        pictures: coding of pictures, see ``check_pictures``.
        renderer: which one draws.
        splits: ``train``, ``val``, ``test`` -> share of the episodes, which sum to 1; see ``split_of``.
        classes: those that exports label, with these numbers; none = all of the scene. Truth is whole either way.
        negatives: largest share of the pictures without a labelled object, in exports of single pictures; see
            ``benchmarks.data.exports.exporter``.
        background: whether pictures without targets, which trackers learn from, are stored where the scene has them.
        scene: its edition, see ``benchmarks.run.editions``. packages: name -> version of what its bytes depend on.
    """

    scenario: str
    preset: str
    seeds: tuple[int, int]
    channels: tuple[str, ...]
    pictures: str = "blosc2"
    renderer: RendererName = "raster"
    splits: Mapping[str, float] = field(default_factory=dict)
    classes: tuple[str, ...] = ()
    negatives: float = 1.0
    background: bool = True
    scene: str = ""
    packages: dict[str, str] = field(default_factory=dict)
    format: int = FORMAT

    def __post_init__(self) -> None:
        """Raise ValueError for a value that is not possible."""
        known = channels_of(catalog.scenario(self.scenario))
        for channel in self.channels:
            check("channels", channel in known, f"some of {', '.join(known)}", repr(channel))
        check_pictures(self.pictures)
        check("seeds", 0 <= self.seeds[0] < self.seeds[1], "A:B with 0 <= A < B", ":".join(map(str, self.seeds)))
        for name, share in self.splits.items():
            check_choice("splits", name, SPLITS)
            check(f"splits {name}", is_number(share) and 0 <= share <= 1, "a share of 0 to 1", share)
        total = sum(self.splits.values())
        check("splits", not self.splits or abs(total - 1) < 1e-9, "shares that sum to 1", f"{total:g}")
        check("classes", len(set(self.classes)) == len(self.classes), "each class once", ", ".join(self.classes))
        check("negatives", is_number(self.negatives) and 0 <= self.negatives <= 1, "a share of 0 to 1", self.negatives)
        self.configuration()

    def split_of(self, seed: int) -> str:
        """Return the split of an episode. It depends on the seed, the preset and the shares alone: whatever a set grows
        to, an episode stays where it is, and of any successive seeds each split has nearly its share. Episodes of one
        day, whose place and weather are the same (``Scenario.day_of``), are in one split.

        Episodes of the benchmark's own test split are always ``test``, so that nothing is trained on them; without
        shares all others are ``train``.
        """
        if seed in TEST_SPLIT:
            return "test"
        place, end = (self._first_of_day(seed) * _TURN) % _TURNS / _TURNS, 0.0
        for name in SPLITS:
            end += self.splits.get(name, 0.0)
            if place < end:
                return name
        # Shares such as 0.7 + 0.2 + 0.1 may sum to a little less than 1.
        return next((name for name in reversed(SPLITS) if self.splits.get(name)), "train")

    def configuration(self, seed: int | None = None) -> Any:
        """Return the preset as in the episode of a seed, None = the first one. Raises ValueError for an unknown one."""
        return catalog.scenario(self.scenario).configuration(self.preset, self.seeds[0] if seed is None else seed)

    def day_of(self, seed: int) -> int:
        """Return the seed of the first episode with the same background pictures.

        Drawn values may differ between episodes of a day: one that has others than the first has its own pictures.
        """
        first = self._first_of_day(seed)
        return first if first == seed or self.configuration(first) == self.configuration(seed) else seed

    def _first_of_day(self, seed: int) -> int:
        day_of = catalog.scenario(self.scenario).day_of
        return seed if day_of is None else day_of(self.configuration(seed), seed)

    def episode(self, seed: int, background: bool = True) -> Episode:
        """Build an episode of the data set, with all truth. Raises ValueError if a controller has to steer it.

        Args:
            background: whether it has background pictures; False is faster.
        """
        with of_seed(seed):
            preset = self.configuration(seed)
        check("preset", not preset.closed_loop, "one on a set path or at rest", f"{self.preset!r}, in closed loop")
        with of_seed(seed):
            scenario = catalog.scenario(self.scenario)
            return scenario.episode(preset, seed, renderer=self.renderer, background=background)

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
        return Request(**(_renamed(values) if version in _READ_TOO else values))
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        raise ValueError(f"{where}: expected the description of a data set, got {error}") from None


def part_names(content: bytes | str) -> tuple[str, ...]:
    """Return the folders of the parts that a ``dataset.json`` names; none for a data set."""
    with suppress(ValueError, AttributeError):
        return tuple(json.loads(content).get("parts", ()))
    return ()


def _renamed(values: dict[str, Any]) -> dict[str, Any]:
    """Return the request of an earlier format with size, rate and number of frames in the preset's name."""
    width_px, height_px = values.pop("size_px") or (None, None)
    changes = {"width_px": width_px, "height_px": height_px}
    changes |= {name: values.pop(name) for name in ("rate_hz", "frame_count")}
    settings = (f"{name}={value:g}" for name, value in changes.items() if value is not None)
    return values | {"preset": with_values(values["preset"], settings)}


def first_episode(request: Request, on_error: OnError = "stop", background: bool = False) -> Episode:
    """Build the first episode; with ``skip`` the first that can be built. Raises what the last one tried raises."""
    *others, last = range(*request.seeds) if on_error == "skip" else request.seeds[:1]
    for seed in others:
        try:
            return request.episode(seed, background)
        except OSError:
            # Of the disk, not of the episode.
            raise
        except Exception:
            continue
    return request.episode(last, background)


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
