"""The gallery follows the catalogue: a new scene, version or preset stands there by itself, with one picture."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from scenarios import catalog
from scenarios.road_town.scenario import ROAD_TOWN
from tools.gallery import page
from tools.gallery.page import ShownPreset, gallery_page, picture_of, shown_presets, write_pictures

FOGGY = replace(
    ROAD_TOWN, id="road-town-v3", presets={"foggy": replace(ROAD_TOWN.presets["quick"], summary="nothing is seen")}
)


@pytest.fixture
def plain_file_names(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without digests of presets."""
    monkeypatch.setattr(page, "preset_edition", lambda *_: "town 1")


def sections() -> dict[str, str]:
    _, *parts = gallery_page("../made").split("\n## ")
    return {part.partition("\n")[0]: " ".join(part.partition("\n")[2].split()) for part in parts}


@pytest.mark.usefixtures("plain_file_names")
def test_each_preset_has_a_picture_and_its_line() -> None:
    (town,) = (text for name, text in sections().items() if name == ROAD_TOWN.id)
    for seed, (name, preset) in enumerate(ROAD_TOWN.presets.items()):
        assert f"{{figure}} ../made/{name}-{seed}-town-1.jpg" in town
        assert f"`{name}`: {preset.summary}" in town
    assert "A car in a town" in town
    assert "[frame-out](/docs/reference.md#metrics-of-suite-frame-out)" in town
    assert "`frameout/RoadTownFollow-v3`." in town
    assert "Older version" not in town


def test_a_new_version_takes_the_place_of_the_old_one(monkeypatch: pytest.MonkeyPatch) -> None:
    standing = tuple(each for each in catalog.entries() if not each.is_next)
    monkeypatch.setattr(catalog, "_ENTRIES", standing)
    before = list(sections())
    monkeypatch.setattr(catalog, "_ENTRIES", (*standing, catalog.Entry("road-town-v3", f"{__name__}:FOGGY")))
    after = sections()
    assert list(after) == [name.replace("road-town-v2", "road-town-v3") for name in before]
    assert "`foggy`: nothing is seen" in after["road-town-v3"]
    assert "Older version: `road-town-v2` (`paper-a2`, " in after["road-town-v3"]
    assert "Env:" not in after["road-town-v3"]


def test_the_next_edition_stands_beside_the_one_of_the_tables() -> None:
    assert [name for name in sections() if name.startswith("road-town")] == ["road-town-v2", "road-town-v3"]


FISH = ShownPreset("fish-tank-v1", "quick", seed=2)


@pytest.fixture
def only_fish(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "shown_presets", lambda: iter([FISH]))


def test_every_preset_of_the_latest_versions_is_shown_on_a_development_seed() -> None:
    latest: dict[tuple[str, bool], int] = {}
    for each in catalog.entries():
        name, version = re.fullmatch(r"(.+)-v(\d+)", each.id).groups()
        latest[name, each.is_next] = max(latest.get((name, each.is_next), 0), int(version))
    ids = [f"{name}-v{version}" for (name, _), version in latest.items()]
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
    assert width == page.WIDTH_PX
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
    monkeypatch.setattr(page, "picture_of", lambda shown: drawn.append(shown) or np.zeros((6, 8, 3), np.uint8))
    assert write_pictures(tmp_path / "new", workers=0) == 1
    (first,) = (tmp_path / "new").iterdir()
    assert cv2.imread(str(first)).shape == (6, 8, 3)
    assert write_pictures(tmp_path / "new", workers=0) == 0
    monkeypatch.setattr(page, "preset_edition", lambda *_: "another")
    assert write_pictures(tmp_path / "new", workers=0) == 1
    assert drawn == [FISH, FISH]
    assert {FISH.file_name, first.name} == {each.name for each in (tmp_path / "new").iterdir()}
