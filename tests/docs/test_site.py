"""The site as `make docs` builds it: without a warning, whole, and without anything from elsewhere."""

from __future__ import annotations

import contextlib
import io
import re
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import cv2
import numpy as np
import pytest
from bs4 import BeautifulSoup
from sphinx.cmd.build import build_main

from scenarios import catalog
from tools.gallery.page import WIDTH_PX, ShownPreset, shown_presets, write_pictures

ROOT = Path(__file__).parents[2]
DRAWN = ShownPreset("fish-tank-v1", "quick", seed=2)
LOADED = {"img": "src", "script": "src", "link": "href", "source": "src", "iframe": "src", "object": "data"}
OPENED = (
    *("docs/index", "docs/gallery", "docs/researcher", "docs/reference", "docs/envs", "docs/results/papers"),
    *("RESULTS", "examples/a_bench_in_python"),
)


def build(folder: Path) -> None:
    """Build it as `make docs` does, in ``folder`` in place of build/docs."""
    (options,) = re.findall(
        r"sphinx-build (.+) -d build/docs/pages \. build/site$", (ROOT / "Makefile").read_text(), re.M
    )
    said = io.StringIO()
    with contextlib.chdir(ROOT), contextlib.redirect_stderr(said), warnings.catch_warnings():
        # MyST calls what Sphinx is about to rename.
        warnings.simplefilter("ignore", PendingDeprecationWarning)
        status = build_main([*options.split(), "-d", str(folder / "pages"), ".", str(folder / "site")])
    assert status == 0, said.getvalue()


def put_grey_picture(folder: Path, shown: ShownPreset) -> None:
    cv2.imwrite(str(folder / "gallery" / shown.file_name), np.full((9, 16, 3), 128, np.uint8))


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build it with one picture that is drawn, and grey ones in place of the others, which take minutes."""
    folder = tmp_path_factory.mktemp("docs")
    (folder / "gallery").mkdir()
    for shown in shown_presets():
        if shown != DRAWN:
            put_grey_picture(folder, shown)
    assert write_pictures(folder / "gallery", workers=0) == 1
    build(folder)
    return folder / "site"


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, BeautifulSoup]:
    return {path: BeautifulSoup(path.read_text(), "html.parser") for path in site.rglob("*.html")}


def addresses(page: BeautifulSoup, attributes: dict[str, str]) -> Iterator[str]:
    for tag, attribute in attributes.items():
        yield from (found[attribute] for found in page.find_all(tag, {attribute: True}))


@pytest.mark.heavy
def test_every_link_and_picture_leads_to_something(pages: dict[Path, BeautifulSoup]) -> None:
    names = {path: {found["id"] for found in page.find_all(id=True)} for path, page in pages.items()}
    dead = []
    for path, page in pages.items():
        for address in addresses(page, {"a": "href", **LOADED}):
            place, _, name = unquote(address).partition("#")
            target = (path.parent / place.partition("?")[0]).resolve() if place else path
            if "://" in address or address.startswith("data:"):
                continue
            if not target.is_file() or (name and target in names and name not in names[target]):
                dead.append((path.name, address))
    assert dead == []
    assert sum(len(list(addresses(page, {"a": "href"}))) for page in pages.values()) > 500


@pytest.mark.heavy
def test_nothing_is_loaded_from_elsewhere(site: Path, pages: dict[Path, BeautifulSoup]) -> None:
    loaded = [address for page in pages.values() for address in addresses(page, LOADED)]
    assert [address for address in loaded if re.match(r"(\w+:)?//", address)] == []
    assert len(loaded) > 100
    for sheet in site.rglob("*.css"):
        assert re.findall(r"(?:@import|url\()\s*[\"']?(?:\w+:)?//", sheet.read_text()) == [], sheet


@pytest.mark.heavy
def test_each_preset_of_the_catalogue_is_in_the_gallery(site: Path, pages: dict[Path, BeautifulSoup]) -> None:
    figures = pages[site / "docs/gallery.html"].find_all("figure")
    told = [
        (Path(each.img["src"]).name, " ".join(each.select_one(".caption-text").get_text().split())) for each in figures
    ]
    expected = [(each.file_name, f"{each.preset}: {summary_of(each)}") for each in shown_presets()]
    # Apostrophes are made typographic.
    assert [(name, words.replace("\u2019", "'")) for name, words in told] == expected
    drawn = cv2.imread(str(site / "_images" / DRAWN.file_name))
    assert drawn.shape[1] == WIDTH_PX
    assert drawn.std() > 10


def summary_of(shown: ShownPreset) -> str:
    return str(catalog.scenario(shown.scenario).presets[shown.preset].summary)


@pytest.mark.heavy
@pytest.mark.usefixtures("pages")
def test_a_new_preset_is_in_the_next_build(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    presets = catalog.scenario(DRAWN.scenario).presets
    monkeypatch.setitem(presets, "shallow", replace(presets["quick"], summary="hardly any water"))
    put_grey_picture(site.parent, ShownPreset(DRAWN.scenario, "shallow", seed=len(presets) - 1))
    build(site.parent)
    assert "hardly any water" in (site / "docs/gallery.html").read_text()


def test_every_page_at_the_top_and_every_way_in_is_in_the_contents(
    site: Path, pages: dict[Path, BeautifulSoup]
) -> None:
    start = pages[site / "docs/index.html"]
    listed = {found["href"] for found in start.select(".sidebar-tree a")}
    tops = {f"../{path.stem}.html" for path in ROOT.glob("*.md") if path.name != "README.md"}
    assert tops >= {"../RESULTS.html", "../CONTRIBUTING.html", "../CHANGELOG.html"}
    pages_of_results = {
        f"results/{path.stem}.html" for path in ROOT.glob("docs/results/*.md") if path.stem[-9:] != ".template"
    }
    assert len(pages_of_results) >= 8
    made = {"gallery.html", "reference.html", "envs.html"}
    assert listed >= {"researcher.html", "engineer.html", "student.html", *made, *tops, *pages_of_results}
    assert "url=docs/index.html" in (site / "index.html").read_text()


def test_definitions_stand_on_pages_of_their_own(site: Path, pages: dict[Path, BeautifulSoup]) -> None:
    reference, envs = (pages[site / f"docs/{name}.html"] for name in ("reference", "envs"))
    assert reference.find(id="metrics-of-suite-frame-out") is not None
    assert "offscreen_error_30_m" in reference.article.get_text()
    assert "frameout/RoadTownFollow-v3" in envs.article.get_text()


def test_no_section_of_the_readme_is_left_out(pages: dict[Path, BeautifulSoup]) -> None:
    """Its parts stand in several pages, cut at its headings."""
    texts = " ".join(" ".join(page.article.get_text().split()) for page in pages.values() if page.article)
    for block in re.findall(r"^```\w+(?: \w+)?\n(.+?)^```$", (ROOT / "README.md").read_text(), re.M | re.S):
        assert " ".join(block.split()) in texts


def test_a_link_to_a_source_file_opens_the_file(site: Path, pages: dict[Path, BeautifulSoup]) -> None:
    (link,) = {
        found["href"] for found in pages[site / "CONTRIBUTING.html"].find_all("a", string="trackers/protocols.py")
    }
    assert (site / link).read_bytes() == (ROOT / "trackers/protocols.py").read_bytes()


@pytest.mark.parametrize("width_px", [1280, 390])
def test_a_browser_opens_it_offline(browser: Any, site: Path, width_px: int) -> None:
    page = browser.new_page(viewport={"width": width_px, "height": 900})
    wrong: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: wrong.append(message.text))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    for name in OPENED:
        page.goto((site / f"{name}.html").as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= width_px, name
        too_wide = """[...document.querySelectorAll("article *")]
            .filter(each => !each.closest(".table-wrapper, pre, svg"))
            .filter(each => each.getBoundingClientRect().right > innerWidth + 0.5)
            .map(each => each.outerHTML.slice(0, 80))"""
        assert page.evaluate(too_wide) == [], name
    page.goto((site / "index.html").as_uri())
    page.wait_for_url("**/docs/index.html")
    assert wrong == []
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []
    page.close()
