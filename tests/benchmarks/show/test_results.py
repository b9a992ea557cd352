"""Results from Python: tables hold what the rows hold, numbers apart from lists, and plots are pictures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from benchmarks import Results
from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.show.palette import line_styles
from benchmarks.show.results import lists_table, metric_chart, numbers_table, over_chart
from tests.benchmarks.fake_rows import TRACKERS, write_rows


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    directory = tmp_path_factory.mktemp("results")
    write_rows(directory)
    return Results(directory)


def test_numbers_are_all_there_each_on_a_line_of_its_own(results: Results) -> None:
    rows = [row for row in read_rows(results.directory) if not isinstance(row["value"], list)]
    table = results.rows()
    assert len(table) == len(rows)
    assert table["value"].dtype == table["weight"].dtype == np.float64
    for name in ("suite", "scenario", "preset", "renderer", "tracker", "role", "seed", "metric"):
        assert table[name].tolist() == [row[name] for row in rows]
    values = [np.nan if row["value"] is None else float(row["value"]) for row in rows]
    np.testing.assert_array_equal(table["value"], values)
    assert np.isnan(table["value"]).any()


def test_lines_about_an_event_say_which_and_others_leave_it_empty(results: Results) -> None:
    rows = [row for row in read_rows(results.directory) if not isinstance(row["value"], list)]
    table = results.rows()
    about = [row["frame_out"] or {} for row in rows]
    for key in ("kind", "index", "length_frames", "side"):
        column = table[f"event_{key}"]
        assert [None if value != value else value for value in column] == [each.get(key) for each in about]
    assert table["event_kind"].isna().any()
    assert table["event_kind"].notna().any()


def test_lists_stand_apart_with_the_place_of_each_entry(results: Results) -> None:
    rows = [row for row in read_rows(results.directory) if isinstance(row["value"], list)]
    table = results.lists()
    assert len(table) == sum(len(row["value"]) for row in rows)
    assert set(table["metric"]).isdisjoint(results.rows()["metric"])
    first = table[: len(rows[0]["value"])]
    assert first["entry"].tolist() == list(range(len(first)))
    np.testing.assert_array_equal(first["value"], np.array(rows[0]["value"], dtype=float))


def test_no_rows_are_tables_with_columns_alone() -> None:
    assert list(numbers_table([]).columns[-3:]) == ["metric", "value", "weight"]
    assert len(numbers_table([])) == len(lists_table([])) == 0


def test_means_of_the_table_are_those_of_the_summary(results: Results) -> None:
    """A share over frame-outs: the plain mean of its rows."""
    table, summary = results.rows(), results.summary()
    entries = summary[summary["metric"] == "recovery_rate"].set_index("tracker")
    means = table[table["metric"] == "recovered"].groupby("tracker")["value"].mean()
    for tracker in TRACKERS:
        assert entries.loc[tracker, "mean"] == pytest.approx(means[tracker], rel=1e-5)
    others = results.comparisons()
    assert set(others["other"]) == set(TRACKERS) - {"sharp"}


def test_a_plot_of_a_metric_has_a_dot_with_its_interval_for_each_tracker(results: Results) -> None:
    figure = results.plot("recovery_rate")
    assert isinstance(figure, Figure)
    (axes,) = figure.axes
    summary = results.summary()
    entries = summary[summary["metric"] == "recovery_rate"].set_index("tracker")
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == entries.sort_values("mean", kind="stable", ascending=False).index.tolist()
    # Between the names lie rules.
    dots = axes.lines[: len(names)]
    for name, bar, dot in zip(names, axes.collections, dots, strict=True):
        assert list(dot.get_xdata()) == [entries.loc[name, "mean"]]
        assert bar.get_segments()[0][:, 0].tolist() == [entries.loc[name, "ci_low"], entries.loc[name, "ci_high"]]
    assert to_hex(dots[names.index("sharp")].get_color()) == line_styles([("sharp", "ours")])["sharp"]["color"]
    assert axes.get_xlabel() == "recovery rate, higher is better, 95 % intervals"
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_the_best_stands_above_whatever_is_better(results: Results) -> None:
    (lower,) = results.plot("offscreen_error_30_m").axes
    assert lower.get_yticklabels()[0].get_text() in ("sharp", "oracle_map")
    (ideal,) = results.plot("coverage_95").axes
    assert ideal.get_xlabel() == "coverage 95, ideal: 95.0 %, 95 % intervals"


def test_a_tracker_without_a_mean_is_named_below_the_others(results: Results) -> None:
    summary = json.loads((results.directory / "summary.json").read_text())
    shown = [entry for entry in summary if entry["metric"] == "recovery_rate"]
    nothing = dict.fromkeys(("mean", "ci_low", "ci_high"))
    undefined = [entry | nothing if entry["tracker"] in ("sharp", "oracle_map") else entry for entry in shown]
    chart, _ = metric_chart(undefined, "recovery_rate")
    assert sorted(chart.lines) == sorted(TRACKERS)
    assert {*list(chart.lines)[-2:]} == {"sharp", "oracle_map"}
    assert [name for name, values in chart.lines.items() if not values] == list(chart.lines)[-2:]


def test_trackers_of_several_conditions_are_told_apart(results: Results) -> None:
    summary = json.loads((results.directory / "summary.json").read_text())
    both = [*summary, *(entry | {"preset": "hard"} for entry in summary)]
    chart, styles = metric_chart(both, "recovery_rate")
    assert len(chart.lines) == len(styles) == 2 * len(TRACKERS)
    assert [name.split()[2] for name in chart.lines] == ["standard"] * len(TRACKERS) + ["hard"] * len(TRACKERS)


def test_a_metric_is_plotted_where_another_suite_of_the_folder_lacks_it(results: Results) -> None:
    summary = json.loads((results.directory / "summary.json").read_text())
    other = {"suite": "many", "scenario": "harbour-v1", "metric": "hota"}
    both = [*(entry | other for entry in summary if entry["metric"] == "recovery_rate"), *summary]
    for metric in ("hota", "recovery_rate"):
        assert sorted(metric_chart(both, metric)[0].lines) == sorted(TRACKERS)
    assert over_chart(both, "recovery_rate", "kept_rate")[0].points
    with pytest.raises(ValueError, match=r"metric: expected metrics of one suite, got hota and kept_rate"):
        over_chart(both, "hota", "kept_rate")


def test_two_suites_with_one_metric_of_one_scene_are_told_apart(results: Results) -> None:
    summary = json.loads((results.directory / "summary.json").read_text())
    hota = [entry | {"metric": "hota"} for entry in summary if entry["metric"] == "recovery_rate"]
    both = [entry | {"suite": name, "scenario": "harbour-v1"} for name in ("harbour", "many") for entry in hota]
    lines = metric_chart(both, "hota")[0].lines
    assert len(lines) == 2 * len(TRACKERS)
    assert "sharp, harbour harbour-v1 standard raster" in lines


def test_plots_of_the_report_are_pictures_that_stand_alone(results: Results) -> None:
    figures = results.figures()
    titles = [figure.get_suptitle() for figure in figures]
    assert titles[:2] == ["Where is the target while outside the picture?", "How soon is it found again?"]
    for figure in figures:
        assert figure._repr_png_().startswith(b"\x89PNG")
    # Variants are no lines of plots, nor entries of the legend.
    named = [text.get_text() for text in figures[0].legends[0].get_texts()]
    assert named[0] == "sharp"
    assert {*TRACKERS} - {*named} == {"blunt"}


def test_what_is_not_there_is_said(results: Results, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"metric: expected one of .*recovery_rate.*; got 'recovery'"):
        results.plot("recovery")
    with pytest.raises(ValueError, match=r"directory: expected one that holds records\.jsonl"):
        Results(tmp_path)


def test_a_missing_summary_is_made_again(results: Results) -> None:
    made = json.loads((results.directory / "summary.json").read_text())
    (results.directory / "summary.json").unlink()
    assert results.summary().to_dict("records") == made


def test_each_episode_has_a_line_with_its_own_mean(results: Results) -> None:
    table = results.by_episode("recovery_rate")
    rows = results.rows()
    own = rows[rows["metric"] == "recovered"].groupby(["seed", "tracker"])["value"].mean().unstack()
    assert list(table.index.get_level_values("episode")) == [*map(str, own.index)]
    np.testing.assert_allclose(table[own.columns], own)
    with pytest.raises(ValueError, match=r"metric: expected one of .*recovery_rate.*; got 'recovery'"):
        results.by_episode("recovery")


def test_the_table_of_episodes_stands_on_the_page_and_in_markdown(
    results: Results, capsys: pytest.CaptureFixture[str]
) -> None:
    values = results.by_episode("recovery_rate")
    assert main(["report", str(results.directory), "--by-episode"]) == 0
    lines = [line.split("|")[1:-1] for line in capsys.readouterr().out.splitlines() if line.startswith("|")]
    heads, told = [each.strip() for each in lines[0]], [[cell.strip() for cell in line] for line in lines[2:]]
    assert sorted(heads[1:]) == sorted(values.columns)
    for line, (_, numbers) in zip(told, values.iterrows(), strict=True):
        assert [float(cell) for cell in line[1:]] == [
            pytest.approx(100 * numbers[name], abs=0.06) for name in heads[1:]
        ]
    page = (results.directory / "report.html").read_text()
    assert "Each episode: recovery rate (%) ↑" in page


def test_a_metric_over_another_is_a_figure(results: Results) -> None:
    figure = results.plot("recovery_rate", over="offscreen_error_30_m")
    assert figure.axes[0].get_xlabel() == "offscreen error 30 (m), lower is better"
    assert {text.get_text() for text in figure.legends[0].get_texts()} == {*TRACKERS}
    with pytest.raises(ValueError, match=r"metric: expected one of .*; got 'speed'"):
        results.plot("recovery_rate", over="speed")
