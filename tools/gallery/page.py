"""The gallery: every scene and preset of the catalogue with a picture and a line.

``gallery_page`` returns the page in MyST Markdown; ``write_pictures`` draws what is missing, as ``frameout render``.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.suite import suites
from benchmarks.run.editions import preset_edition
from benchmarks.run.jobs import opened
from benchmarks.run.selection import job_on
from benchmarks.run.workers import in_processes
from benchmarks.show.page import page_environment
from benchmarks.show.replay import replay
from benchmarks.show.showing import drawing_of, suite_watching
from scenarios import catalog
from trackers.atomic_file import write_atomic

WIDTH_PX = 480
_FRAME = 40
"""Late enough for something to have happened, early enough to be there in seconds."""
_SCALE = 2.0
"""Size of the larger view, as in ``frameout render``."""
_JPEG_QUALITY = 82


class ShownPreset(NamedTuple):
    """The episode that shows a preset.

    Attributes:
        scenario: catalogue id with version. preset: its name.
        seed: the preset's place in the scenario, so that presets which differ little show different places.
    """

    scenario: str
    preset: str
    seed: int

    @property
    def file_name(self) -> str:
        """Name of its picture, with the edition of what it shows."""
        edition = preset_edition(self.scenario, self.preset).replace(" ", "-")
        return f"{self.preset}-{self.seed}-{edition}.jpg"


def _versions() -> list[list[catalog.Entry]]:
    """Return the entries of each scenario, as the catalogue has them, the latest version first; a next one alone."""
    found: dict[str, list[catalog.Entry]] = {}
    for entry in catalog.entries():
        found.setdefault(entry.id if entry.is_next else catalog.id_of(catalog.unversioned(entry.id)), []).append(entry)
    return [sorted(entries, key=lambda entry: entry.id != latest) for latest, entries in found.items()]


def shown_presets() -> Iterator[ShownPreset]:
    """Yield every preset of the latest versions."""
    for latest, *_ in _versions():
        for seed, preset in enumerate(catalog.scenario(latest.id).presets):
            yield ShownPreset(latest.id, preset, seed)


def gallery_page(pictures: str) -> str:
    """Return the scenes as Markdown, each under a heading of the second level.

    Args:
        pictures: where the page finds the folder that ``write_pictures`` filled, without a slash at its end.
    """
    shown = list(shown_presets())
    scenes = [
        {
            "scenario": catalog.scenario(latest.id),
            "env_id": latest.env_id,
            "suites": [suite.name for suite in suites().values() if suite.is_about(latest.id)],
            "shown": [each for each in shown if each.scenario == latest.id],
            "older": [catalog.scenario(each.id) for each in older],
        }
        for latest, *older in _versions()
    ]
    template = page_environment(__file__, autoescape=False).get_template("gallery.md.jinja")
    return template.render(scenes=scenes, pictures=pictures)


def picture_of(shown: ShownPreset) -> NDArray[np.uint8]:
    """Return a preset's picture (H, ``WIDTH_PX``, 3): an early frame with its truth, without a tracker."""
    job = job_on(suite_watching(shown.scenario), shown.scenario, shown.preset, shown.seed)
    with opened(job) as live:
        drawing = drawing_of(shown.scenario, live.loop.episode)
        last = min(_FRAME, live.loop.episode.frame_count - 1)
        scale = _SCALE if drawing.uses_larger_view else 1.0
        # Some drawings show what came before, so they see every frame; the larger view is needed of the last alone.
        for instant in replay(live, scale=scale, wanted={last}, frame_count=last + 1):
            picture = drawing.picture(instant)
    size = (WIDTH_PX, round(WIDTH_PX * picture.shape[0] / picture.shape[1]))
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def write_pictures(folder: Path, workers: int) -> int:
    """Write the pictures that ``folder`` lacks, and return how many; ``workers``: processes, 0 = this one."""
    missing = [shown for shown in shown_presets() if not (folder / shown.file_name).exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return len(list(in_processes(partial(_write, folder), missing, workers)))


def _write(folder: Path, shown: ShownPreset) -> None:
    _, encoded = cv2.imencode(".jpg", picture_of(shown)[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    write_atomic(folder / shown.file_name, encoded.tobytes())
