"""Live through an episode once more, to look at it: every instant with truth, estimate and larger view."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.run.contestants import entrant
from benchmarks.run.from_pictures import Contestant
from benchmarks.run.records import Row
from benchmarks.run.versions import versions_of
from benchmarks.video.instant import Instant
from scenarios import catalog
from scenarios.scenario import Episode, RendererName
from sim.rng import generator
from trackers.controllers import catalogue
from trackers.protocols import Controller
from trackers.types import Estimate


@dataclass(frozen=True, slots=True)
class Run:
    """One tracker in one episode, by names, as rows name it.

    Attributes:
        scenario, preset, seed, renderer: the episode.
        tracker: who watches, None for truth alone.
        controller: what steers by the tracker's estimate, None for the set path.
        values: of the tracker's parameters, other than those it was tuned to.
    """

    scenario: str
    preset: str
    seed: int
    renderer: RendererName = "raster"
    tracker: str | None = None
    controller: str | None = None
    values: dict[str, Any] | None = None

    def open(self) -> Episode:
        """Build the episode.

        Raises:
            ValueError: for an unknown name or a negative seed.
        """
        if self.controller is not None and self.tracker is None:
            raise ValueError(f"tracker: expected a name, as {self.controller!r} steers by one; got none")
        source = catalog.scenario(self.scenario)
        closed_loop = self.controller is not None
        return source.episode(self.preset, self.seed, renderer=self.renderer, closed_loop=closed_loop)

    def instants(
        self, episode: Episode, *, scale: float, wanted: Container[int], frame_count: int
    ) -> Iterator[Instant]:
        """Live through ``episode``; the tracker draws the same random numbers as when it was scored."""
        contestant = None
        if self.tracker is not None:
            rng = generator(self.seed, f"tracker/{self.tracker}")
            contestant = entrant(self.tracker, self.values).create(episode, rng)
        carrier = catalog.scenario(self.scenario).carrier.name
        controller = (
            None
            if self.controller is None
            else catalogue.controller_entry(self.controller, carrier).create_as_written()
        )
        return replay(episode, contestant, controller, scale=scale, wanted=wanted, frame_count=frame_count)


def replay(
    episode: Episode,
    contestant: Contestant | None,
    controller: Controller | None,
    *,
    scale: float,
    wanted: Container[int],
    frame_count: int,
) -> Iterator[Instant]:
    """Yield the ``wanted`` ones among the first ``frame_count`` frames; the others are lived through unseen.

    The contestant is told the target's box in frame 0, where that box is its estimate. The controller's
    command of one frame moves the camera to the next, as when the run was scored. At a ``scale`` of 1 the larger
    view is the observed frame itself, and none is drawn.
    """
    command = None
    for index in range(frame_count):
        frame = episode.step(command)
        estimate = None
        if contestant is not None and index == 0:
            box = episode.target_box_xyxy
            contestant.initialise(frame, box.copy())
            estimate = Estimate(0.5 * (box[:2] + box[2:]), box, in_view_probability=1.0)
        elif contestant is not None:
            estimate = contestant.update(frame)
        if controller is not None and estimate is not None:
            command = controller.command(frame.observation, estimate)
        if index in wanted:
            yield Instant(frame, estimate, frame.observation.image_rgb if scale == 1 else episode.larger_view(scale))


def made_by_this_code(tracker: str, rows: Sequence[Row]) -> bool:
    """Return whether a tracker lived through again does what it did when its rows were made, and who steered by it."""
    made, steered_by = rows[0], rows[0]["controller"]
    carrier = catalog.scenario(made["scenario"]).carrier.name
    try:
        controller = None if steered_by is None else catalogue.controller_entry(steered_by, carrier)
        now = versions_of(made["suite"], made["scenario"], made["preset"], entrant(tracker), controller)
        return now == made["versions"]
    except ValueError:
        return False
