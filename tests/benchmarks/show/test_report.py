"""The report: one file, from rows alone, the same for the same rows, with numbers that others agree with."""

from __future__ import annotations

import html.parser
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.contract.rows import read_rows
from benchmarks.contract.suite import suite
from benchmarks.show import plots, tables
from benchmarks.show.charts import Chart, Curve
from benchmarks.show.page import write_report
from benchmarks.show.palette import line_styles
from benchmarks.show.pictures import read_pictures, remove_picture, write_picture
from benchmarks.show.provenance import provenance, sequences_in_words
from benchmarks.statistics.bootstrap import Interval
from tests.benchmarks.fake_rows import TRACKERS, rows_of, write_rows
from trackers.papers import PAPERS

FRAME_OUT = suite("frame-out")


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("results")
    write_rows(directory)
    write_report(directory)
    return directory


@pytest.fixture(scope="module")
def page(results: Path) -> str:
    return (results / "report.html").read_text()


def summary_of(results: Path) -> list[dict[str, object]]:
    return json.loads((results / "summary.json").read_text())


class WellFormed(html.parser.HTMLParser):
    """Checks that every element is closed in order."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.heavy
def test_the_page_is_whole_and_needs_nothing_from_outside(page: str) -> None:
    parser = WellFormed()
    parser.feed(page)
    assert parser.open == []
    for address in re.findall(r'(?:href|src|action)="([^"]*)"', page):
        assert address.startswith(("#", "data:")), address
    for unwanted in ("<script", "@import", "<dc:date", "`"):
        assert unwanted not in page
    assert re.findall(r"url\((?!#)", page) == []


@pytest.mark.heavy
def test_what_the_plots_refer_to_is_theirs_alone(page: str) -> None:
    """Several plots lie in one page: a clip path of one must not cut another."""
    ids = re.findall(r' id="([^"]*)"', page)
    for reference in set(re.findall(r"url\(#([^)]+)\)", page)) | set(re.findall(r'xlink:href="#([^"]+)"', page)):
        assert ids.count(reference) == 1


@pytest.mark.heavy
def test_the_same_rows_make_the_same_page(results: Path, page: str, tmp_path: Path) -> None:
    write_rows(tmp_path)
    assert write_report(tmp_path).read_text() == page


@pytest.mark.heavy
def test_every_tracker_stands_on_the_page_with_its_score(results: Path, page: str) -> None:
    text = re.sub(r"<[^>]+>", " ", page)
    for tracker in TRACKERS:
        assert tracker in text
    for entry in summary_of(results):
        if entry["metric"] == "recovery_rate":
            assert re.search(rf"{entry['tracker']}\s.*{100 * float(str(entry['mean'])):.1f}", text, re.DOTALL)


def test_names_from_rows_are_escaped(tmp_path: Path) -> None:
    rows = [{**row, "tracker": "<script>alert(1)</script>"} for row in rows_of("colour_pf", 10_000)]
    (tmp_path / "records.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    page = write_report(tmp_path).read_text()
    assert "<script" not in page
    assert "&lt;script&gt;" in page


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"directory: expected one that holds"):
        write_report(tmp_path)
    (tmp_path / "records.jsonl").write_text("")
    with pytest.raises(ValueError, match=r"directory: expected one that holds results"):
        write_report(tmp_path)


@pytest.mark.parametrize("tracker", ["colour_pf", "hold"])
def test_one_tracker_on_one_seed_makes_a_page(tmp_path: Path, tracker: str) -> None:
    (tmp_path / "records.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows_of(tracker, 0)))
    assert tracker in write_report(tmp_path).read_text()


def chart_of(curve: Curve, **changes: Any) -> Chart:
    return Chart(**{"title": "t", "words": "", "curves": {"a": curve}, "x_label": "x", "x_scale": "frames"} | changes)


@pytest.mark.parametrize("changes", [{}, {"steps": True}, {"y_scale": "log", "rule": (0.1, "rule")}])
def test_plots_draw_the_numbers_they_are_given(changes: dict[str, Any]) -> None:
    curve = Curve(np.arange(1.0, 40.0), *np.linspace(0.1, [0.4, 0.3, 0.5], 39).T)
    (axes,) = plots.figure_of(chart_of(curve, **changes), line_styles([("a", "ours")])).axes
    drawn = axes.lines[0].get_xydata()
    np.testing.assert_array_equal(drawn, np.stack([curve.x, curve.mean], axis=1))
    (band,) = axes.collections
    assert band.get_datalim(axes.transData).get_points()[1].tolist() == [39.0, 0.5]


def test_dots_of_one_line_stand_apart_from_the_top_and_their_trackers_in_the_legend() -> None:
    """Here of controllers and trackers: ours above, a user's own tracker in a colour that no controller has."""
    lines = {
        "reentry": {"one": Interval(0.9, 0.8, 0.95), "two": Interval(0.5, 0.4, 0.6)},
        "hold": {"one": Interval(0.2, 0.1, 0.3)},
    }
    styles = line_styles([("one", "ours"), ("two", "external")])
    chart = Chart(title="t", words="", lines=lines, x_label="seen", x_scale="share")
    figure = plots.figure_of(chart, styles)
    (axes,) = figure.axes
    drawn = [(line, *at) for line in axes.lines if line.get_marker() == "o" for at in line.get_xydata()]
    dots = {(x, line.get_color()): y for line, x, y in drawn}
    # The axis points down.
    ours, own, lower = (dots[x, styles[name]["color"]] for x, name in ((0.9, "one"), (0.5, "two"), (0.2, "one")))
    assert ours < own < lower
    assert axes.yaxis_inverted()
    assert [label.get_text() for label in axes.get_yticklabels()] == ["reentry", "hold"]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["one", "two"]


def test_styles_differ_and_ours_is_in_front() -> None:
    styles = line_styles([(name, role) for name, (role, *_) in TRACKERS.items()])
    assert len({str(style) for style in styles.values()}) == len(styles)
    assert max(styles, key=lambda name: styles[name]["zorder"]) == "sharp"


def entry(tracker: str, metric: str, mean: float, role: str = "baseline") -> dict[str, object]:
    interval = {"ci_low": mean - 0.1, "ci_high": mean + 0.1, "n": 5}
    return {"scenario": "town", "tracker": tracker, "role": role, "metric": metric, "mean": mean, **interval}


def test_the_leaderboard_puts_the_best_first_and_marks_it() -> None:
    entries = [entry("a", "recovery_rate", 0.3), entry("b", "recovery_rate", 0.7)]
    entries += [entry("a", "offscreen_error_30_m", 2.0), entry("b", "offscreen_error_30_m", 9.0)]
    entries += [entry("a", "coverage_95", 0.94), entry("b", "coverage_95", 1.0)]
    table = tables.leaderboard(FRAME_OUT, entries, ("baseline",))
    assert [line.names[0] for line in table.lines] == ["b", "a"]
    best = {
        column.title: line.names[0]
        for line in table.lines
        for column, cell in zip(table.columns, line.cells, strict=True)
        if cell.mark == "best"
    }
    # An error is better where it is low, a coverage where it is near 95 %.
    assert best == {"recovery rate": "b", "offscreen error 30": "a", "coverage 95": "a"}


@pytest.mark.parametrize("role", ["oracle", "blind"])
def test_a_reference_is_never_marked_best_and_shares_the_scale(role: str) -> None:
    entries = [
        entry("a", "offscreen_error_30_m", 8.0),
        entry("reference", "offscreen_error_30_m", 1.0, role=role),
        entry("b", "offscreen_error_30_m", 9.9),
    ]
    cell = tables.leaderboard(FRAME_OUT, entries, (role,)).lines[0].cells[0]
    assert cell.mark == ""
    assert cell.bar is not None
    assert cell.bar[2] == pytest.approx(10.0)
    best = tables.leaderboard(FRAME_OUT, entries, ("baseline",)).lines[0]
    assert (best.names, best.cells[0].mark) == (("a",), "best")


def test_references_come_last_in_a_part_of_their_own(results: Path, page: str) -> None:
    """An oracle that leads in every column stands below the last competitor, in text and on the page."""
    entries = [
        entry("told", "offscreen_error_30_m", 1.0, role="oracle"),
        entry("a", "offscreen_error_30_m", 8.0),
        entry("unseeing", "offscreen_error_30_m", 0.5, role="blind"),
        entry("b", "offscreen_error_30_m", 9.9),
    ]
    table = tables.leaderboard(FRAME_OUT, entries, ("baseline", "blind", "oracle"))
    assert [line.names[0] for line in table.lines] == ["a", "b", "unseeing", "told"]
    assert [[line.names[0] for line in part] for part in table.parts] == [["a", "b"], ["unseeing", "told"]]
    for tables_of in page.split("Every metric"):
        parts = re.search(r"references, not ranked(.*?)</tbody>", tables_of, re.DOTALL)
        assert parts is not None
        assert "oracle_map" in parts[1]
        assert "sharp" not in parts[1]


@pytest.mark.parametrize(
    ("difference", "low", "high", "p_holm", "mark"),
    [
        (0.2, 0.1, 0.3, 0.01, "better"),
        (-0.2, -0.3, -0.1, 0.01, "worse"),
        (0.2, -0.1, 0.3, 0.01, ""),
        (0.2, 0.1, 0.3, 0.2, ""),
    ],
)
def test_differences_are_marked_only_where_no_doubt_is_left(
    difference: float, low: float, high: float, p_holm: float, mark: str
) -> None:
    comparison = {"scenario": "town", "other": "a", "metric": "recovery_rate", "difference": difference}
    comparison |= {"ci_low": low, "ci_high": high, "p_holm": p_holm}
    (line,) = tables.paired_differences(FRAME_OUT, [comparison], ["a"]).lines
    assert line.cells[0].mark == mark
    errors = tables.paired_differences(FRAME_OUT, [{**comparison, "metric": "offscreen_error_30_m"}], ["a"])
    opposite = {"better": "worse", "worse": "better", "": ""}
    assert errors.lines[0].cells[0].mark == opposite[mark]


def test_provenance_says_what_was_run(results: Path) -> None:
    made = provenance(read_rows(results))
    assert (made["episodes"], made["frames"], made["split"]) == (8, 3200, "test split")
    assert made["seeds"] == "10,000–10,007"
    assert "--seeds 10000:10008" in made["command"]
    assert made["events"].startswith("24 frame-outs of ")
    assert "8 with a turn at a crossing, 8 with a way off the road" in made["events"]


def test_metrics_link_to_their_definitions_on_the_page(page: str) -> None:
    links = set(re.findall(r'href="#(frame-out-\w+)"', page))
    assert "frame-out-recovery_rate" in links
    assert links <= set(re.findall(r'<dt id="(.*?)">', page))
    assert "area under the Kaplan-Meier curve of recovery_frames" in page


def test_failures_are_reported(tmp_path: Path) -> None:
    rows = rows_of("hold", 10_000)
    rows.insert(0, {**rows[0], "metric": "failed_at_frame", "value": 17.0, "frame_out": None})
    (tmp_path / "records.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    assert "hold, seed 10000: failed at frame 17" in write_report(tmp_path).read_text()


@pytest.mark.heavy
def test_pictures_are_embedded_in_their_section(tmp_path: Path) -> None:
    write_rows(tmp_path, range(10_000, 10_003))
    condition = ("frame-out", "road-town-v2", "standard", "raster", "")
    image = np.full((20, 30, 3), (200, 30, 30), dtype=np.uint8)
    write_picture(tmp_path, "x", image, condition, "A picture", "what <it> shows", made_from="seed 1")
    write_picture(tmp_path, "y", image, (*condition[:2], "hard", "raster", ""), "Elsewhere", "no", "seed 1")
    (picture, _) = read_pictures(tmp_path)
    page = write_report(tmp_path).read_text()
    assert picture["source"] in page
    assert "what &lt;it&gt; shows" in page
    assert "Elsewhere" not in page
    remove_picture(tmp_path, "x")
    assert len(read_pictures(tmp_path)) == 1


def test_the_papers_of_methods_stand_below_the_leaderboard(page: str) -> None:
    notes = re.findall(r'<p class="note">(.*?)</p>', page, re.S)
    (named,) = [note for note in notes if "paper A" in note]
    assert re.findall(r'<span class="name">(\w+)</span>', named) == ["colour_pf", "road_shape_pf"]
    assert PAPERS["A"].reference() in named
    assert "paper B" not in page


@pytest.mark.parametrize("last", [0, 2, 130])
def test_frames_are_counted_in_whole_numbers(last: int) -> None:
    x = np.arange(last + 1.0)
    styles = line_styles([("a", "ours")])
    picture = plots.plot_of(chart_of(Curve(x, x + 1.0, x + 0.5, x + 1.5), y_scale="log"), styles).svg
    axis = picture[picture.index('id="matplotlib.axis_1"') : picture.index('id="matplotlib.axis_2"')]
    ticks = re.findall(r"<text [^>]*>([^<]*)</text>", axis)[:-1]
    assert len(ticks) >= 2
    assert all(tick.isdigit() for tick in ticks), ticks


def test_an_error_of_almost_nothing_does_not_squeeze_the_others() -> None:
    x = np.arange(3.0)
    values = np.array([1e-14, 5.0, 50.0])
    chart = Chart(
        title="t",
        words="",
        curves={"a": Curve(x, values, values, values)},
        x_label="x",
        x_scale="frames",
        y_scale="log",
    )
    low, high = plots.figure_of(chart, line_styles([("a", "ours")])).axes[0].get_ylim()
    assert 1e-3 < low < 5.0
    assert high >= 50.0


def test_sequences_are_told_by_suite() -> None:
    recorded = {
        "scenario": "real",
        "renderer": "real",
        "preset": "set",
        "sequence": "Car",
        "recorded": ["--real", "set"],
    }
    rows = [row | recorded for row in rows_of("sharp", 0)]
    other = [row | {"suite": "many", "sequence": "Crowd", "seed": 1} for row in rows if row["frame_out"] is None]
    (line,) = sequences_in_words(FRAME_OUT, [*rows, *other])
    assert line.startswith("set: 1 sequence, ")
    assert "with a return that is judged" in line
    assert list(sequences_in_words(suite("many"), [*rows, *other])) == [line.partition(";")[0]]
    assert list(sequences_in_words(suite("stereo"), rows)) == []
