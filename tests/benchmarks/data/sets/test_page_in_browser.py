"""The page as a browser shows it: no error, no request, every picture there, nothing wider than the window."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.page import render_page


@pytest.fixture(scope="module")
def page_file(hand_made: DataSet, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(render_page(hand_made))
    return path


@pytest.mark.heavy
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width_px", [1280, 390])
def test_it_opens_offline(browser: Any, page_file: Path, width_px: int, scheme: str) -> None:
    page = browser.new_page(viewport={"width": width_px, "height": 900}, color_scheme=scheme)
    wrong: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: wrong.append(message.text))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(page_file.as_uri())
    assert wrong == []
    assert [url for url in asked if not url.startswith("data:")] == [page_file.as_uri()]
    shown = page.evaluate("[...document.images].map(each => each.complete && each.naturalWidth > 0)")
    assert shown == [True] * 2
    assert page.evaluate("document.documentElement.scrollWidth") <= width_px
    # What scrolls inside its own frame may be wider; all else ends within the window.
    too_wide = """[...document.querySelectorAll("body *")]
        .filter(each => !each.closest(".scroll, svg") && each.getBoundingClientRect().right > innerWidth + 0.5)
        .map(each => each.outerHTML.slice(0, 80))"""
    assert page.evaluate(too_wide) == []
    page.close()
