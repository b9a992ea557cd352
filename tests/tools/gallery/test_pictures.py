"""Pictures of presets: all of the latest versions, early frames of development episodes, drawn once."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from scenarios import catalog
from tools.gallery import pictures
from tools.gallery.pictures import ShownPreset, picture_of, shown_presets, write_pictures

FISH = ShownPreset("fish-tank-v1", "quick", seed=2)


@pytest.fixture
def only_fish(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pictures, "shown_presets", lambda: iter([FISH]))


def test_every_preset_of_the_latest_versions_is_shown_on_a_development_seed() -> None:
    latest: dict[str, int] = {}
    for name, version in (re.fullmatch(r"(.+)-v(\d+)", each).groups() for each in catalog.names()):
        latest[name] = max(latest.get(name, 0), int(version))
    ids = [f"{name}-v{version}" for name, version in latest.items()]
    shown = list(shown_presets())
    assert [(each.scenario, each.preset) for each in shown] == [
        (name, preset) for name in ids for preset in catalog.scenario(name).presets
    ]
    assert all(0 <= each.seed < 10_000 for each in shown)
    assert len({(each.scenario, each.seed) for each in shown}) == len(shown)


@pytest.mark.heavy
def test_the_picture_is_of_an_early_frame_of_that_episode() -> None:
    picture = picture_of(FISH)
    height, width = picture.shape[:2]
    assert width == pictures.WIDTH_PX
    episode = catalog.scenario(FISH.scenario).episode(FISH.preset, FISH.seed)
    seen = [cv2.resize(episode.step().observation.image_rgb, (width, height)).astype(float) for _ in range(60)]
    episode.close()
    # Marks and scaling change a few pixels; fish that swim on change more.
    away = [np.abs(picture - each).mean() for each in seen]
    assert np.argmin(away) == 40
    assert away[40] < 4


@pytest.mark.usefixtures("only_fish")
def test_a_picture_is_drawn_once_for_each_edition_of_the_scene(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    drawn = []
    monkeypatch.setattr(pictures, "picture_of", lambda shown: drawn.append(shown) or np.zeros((6, 8, 3), np.uint8))
    assert write_pictures(tmp_path / "new", workers=0) == 1
    (first,) = (tmp_path / "new").iterdir()
    assert cv2.imread(str(first)).shape == (6, 8, 3)
    assert write_pictures(tmp_path / "new", workers=0) == 0
    monkeypatch.setattr(pictures, "preset_edition", lambda *_: "another")
    assert write_pictures(tmp_path / "new", workers=0) == 1
    assert drawn == [FISH, FISH]
    assert {FISH.file_name, first.name} == {each.name for each in (tmp_path / "new").iterdir()}
