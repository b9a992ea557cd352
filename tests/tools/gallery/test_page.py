"""The gallery's page follows the catalogue: a new scene, version or preset stands there by itself."""

from __future__ import annotations

from dataclasses import replace

import pytest

from scenarios import catalog
from scenarios.road_town.scenario import ROAD_TOWN
from tools.gallery import pictures
from tools.gallery.page import gallery_page

FOGGY = replace(
    ROAD_TOWN, id="road-town-v3", presets={"foggy": replace(ROAD_TOWN.presets["quick"], summary="nothing is seen")}
)


@pytest.fixture(autouse=True)
def plain_file_names(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without digests of presets."""
    monkeypatch.setattr(pictures, "preset_edition", lambda *_: "town 1")


def sections() -> dict[str, str]:
    _, *parts = gallery_page("../made").split("\n## ")
    return {part.partition("\n")[0]: " ".join(part.partition("\n")[2].split()) for part in parts}


def test_each_preset_has_a_picture_and_its_line() -> None:
    (town,) = (text for name, text in sections().items() if name == ROAD_TOWN.id)
    for seed, (name, preset) in enumerate(ROAD_TOWN.presets.items()):
        assert f"{{figure}} ../made/{name}-{seed}-town-1.jpg" in town
        assert f"`{name}`: {preset.summary}" in town
    assert "A car in a town" in town
    assert "[frame-out](/docs/reference.md#metrics-of-suite-frame-out)" in town
    assert "`frameout/RoadTownFollow-v2`." in town
    assert "Older version" not in town


def test_a_new_version_takes_the_place_of_the_old_one(monkeypatch: pytest.MonkeyPatch) -> None:
    before = list(sections())
    entry = catalog.Entry("road-town-v3", f"{__name__}:FOGGY")
    monkeypatch.setattr(catalog, "_ENTRIES", (*catalog.entries(), entry))
    after = sections()
    assert list(after) == [name.replace("road-town-v2", "road-town-v3") for name in before]
    assert "`foggy`: nothing is seen" in after["road-town-v3"]
    assert "Older version: `road-town-v2` (`paper-a2`, " in after["road-town-v3"]
    assert "Env:" not in after["road-town-v3"]
