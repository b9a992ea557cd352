"""RESULTS.md and docs/results come from their templates and the published tables, and no table mixes runs."""

from __future__ import annotations

import itertools
import json
import lzma
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.contract.rows import FILE_NAME
from benchmarks.papers.experiment import experiment_named
from benchmarks.show.tables import REFERENCES
from benchmarks.statistics.summary import write_summary
from tests.benchmarks.fake_rows import write_rows
from tests.tools.command import tools
from tools.publishing import ledger, table_files
from tools.publishing.results_page import results_pages
from tools.publishing.tables import budgets_of
from trackers import registry

ROOT = Path(__file__).parents[3]
PAGES = [ROOT / "RESULTS.md", *(each for each in (ROOT / "docs/results").glob("*.md") if ".template" not in each.name)]
COLUMNS = "columns=['recovery_rate', 'offscreen_error_30_m']"


@pytest.fixture(scope="module")
def contents(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return what the file of a table of hand-made rows holds."""
    rows = tmp_path_factory.mktemp("rows")
    write_rows(rows)
    return {
        "table": "first",
        "command": "frameout bench frame-out",
        "commit": "0123456789",
        "seeds": "10000:10008",
        "budgets": {"trackers": {"sharp": {"trials": 8, "seeds": "0:8"}, "hold": {"trials": 8, "seeds": "0:8"}}},
        "summary": write_summary(rows),
        "findings": [],
    }


@pytest.fixture
def published(checkout: Path, contents: dict[str, Any]) -> dict[str, Any]:
    """Return the contents of a published table ``first``."""
    keep("first", contents)
    return contents


def keep(name: str, contents: dict[str, Any], **other: Any) -> None:
    ledger.TABLES_FOLDER.mkdir(exist_ok=True)
    text = json.dumps({**contents, "table": name, **other})
    (ledger.TABLES_FOLDER / f"{name}.json").write_text(text)


def rendered(template: str) -> str:
    ledger.TEMPLATE.write_text(template)
    return results_pages()[ledger.RESULTS]


def entry(contents: dict[str, Any], tracker: str, metric: str) -> dict[str, Any]:
    (found,) = [each for each in contents["summary"] if (each["tracker"], each["metric"]) == (tracker, metric)]
    return found


def percents(entry: dict[str, Any]) -> str:
    return f"{100 * entry['mean']:.1f} ({100 * entry['ci_low']:.1f}–{100 * entry['ci_high']:.1f})"


def test_a_table_stands_where_the_template_names_it(published: dict[str, Any]) -> None:
    lines = rendered(f"# Head\n\n{{{{ table('first', {COLUMNS}) }}}}\n\nwords\n").splitlines()
    assert lines[:2] == ["# Head", ""]
    assert lines[2] == "| tracker | role | recovery rate (%) ↑ | offscreen error 30 (m) ↓ |"
    assert lines[3] == "| --- | --- | ---: | ---: |"
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[4:9]]
    contestants = {f"`{each['tracker']}`" for each in published["summary"] if each["role"] != "oracle"}
    assert {cell[0] for cell in cells} == contestants
    assert lines[9].startswith(f"| *{REFERENCES}* |")
    assert lines[10].startswith("| `oracle_map` | oracle | ")
    assert {line.count("|") for line in lines[2:11]} == {5}
    recovered = [float(cell[2].split(" ")[0]) for cell in cells]
    assert recovered == sorted(recovered, reverse=True)
    (mine,) = [cell for cell in cells if cell[0] == "`sharp`"]
    assert mine[1:3] == ["ours", percents(entry(published, "sharp", "recovery_rate"))]
    assert lines[11:] == [
        "",
        "Made by `python -m tools publish first`: seeds 10000:10008, commit 0123456789.",
        "",
        "words",
    ]


def test_a_metric_without_rows_has_no_column(published: dict[str, Any]) -> None:
    """Time seen is counted in steered runs alone."""
    assert not any(each["metric"] == "time_seen" for each in published["summary"])
    heads, rule, *lines = rendered("{{ table('first') }}").split("\n\n")[0].splitlines()
    assert "recovery rate" in heads
    assert "time seen" not in heads
    assert {line.count("|") for line in (rule, *lines)} == {heads.count("|")}
    steered = [{**each, "metric": "time_seen"} for each in published["summary"] if each["metric"] == "recovery_rate"]
    keep("second", published, summary=[*published["summary"], *steered])
    with pytest.raises(ValueError, match=r"table: expected the same columns in first, second, got .*time seen"):
        rendered("{{ table('first', 'second') }}")
    with pytest.raises(ValueError, match=r"columns: expected metrics that first have, got 'time_seen'"):
        rendered("{{ table('first', columns=['recovery_rate', 'time_seen']) }}")


def test_a_contestant_without_a_number_has_no_line(published: dict[str, Any]) -> None:
    others = [each for each in published["summary"] if each["tracker"] != "hold"]
    nothing = {**entry(published, "hold", "recovery_rate"), "mean": None, "ci_low": None, "ci_high": None}
    keep("first", published, summary=[*others, nothing])
    shown = rendered(f"{{{{ table('first', {COLUMNS}) }}}}")
    assert {each["tracker"] for each in others} == set(re.findall(r"^\| `(\w+)`", shown, re.MULTILINE))


def test_numbers_in_prose_come_from_the_tables(published: dict[str, Any], tmp_path: Path) -> None:
    text = rendered(
        "{{ value('first', 'sharp', 'recovery_rate') }} {{ value('first', 'sharp', 'offscreen_error_30_m') }}"
    )
    metres = entry(published, "sharp", "offscreen_error_30_m")
    numbers = f"{metres['mean']:.2f} ({metres['ci_low']:.2f}–{metres['ci_high']:.2f})"
    assert text == f"{percents(entry(published, 'sharp', 'recovery_rate'))} {numbers}"
    write_rows(tmp_path)
    write_summary(tmp_path)
    table_files.rows_file("first").write_bytes(lzma.compress((tmp_path / FILE_NAME).read_bytes()))
    (found,) = [
        each
        for each in json.loads((tmp_path / "comparisons.json").read_text())
        if (each["tracker"], each["other"], each["metric"]) == ("sharp", "blunt", "recovery_rate")
    ]
    call = "{{ difference('first', 'sharp', 'blunt', 'recovery_rate') }}"
    assert rendered(call) == percents({**found, "mean": found["difference"]}).replace("-", "\u2212")


def test_tables_of_one_run_stand_below_each_other(published: dict[str, Any]) -> None:
    harder = [{**each, "preset": "hard"} for each in published["summary"]]
    keep("second", published, summary=harder)
    lines = rendered(f"{{{{ table('first', 'second', {COLUMNS}) }}}}\n").splitlines()
    assert lines[0].startswith("| preset | tracker | role | recovery rate")
    shown = ["`standard`"] * 5 + ["`hard`"] * 5 + [f"*{REFERENCES}*", "`standard`", "`hard`"]
    assert [line.split("|")[1].strip() for line in lines[2:15]] == shown
    assert lines[-1] == "Made by `python -m tools publish first second`: seeds 10000:10008, commit 0123456789."


@pytest.mark.parametrize(
    ("other", "message"),
    [
        ({"seeds": "10000:10004"}, "table: expected one range of seeds in first, second, got 10000:10004, 10000:10008"),
        (
            {"budgets": {"trackers": {"blunt": {"trials": 40, "seeds": "0:8"}}}},
            "table: expected trackers of first, second tuned with one budget, "
            "got hold sharp: trials 8, seeds 0:8; blunt: trials 40, seeds 0:8",
        ),
        (
            {"budgets": {"controllers": {"lead": {"trials": 8}, "centre": {"trials": 6}}}},
            "table: expected controllers of first, second tuned with one budget, got lead: trials 8; centre: trials 6",
        ),
    ],
)
def test_a_table_does_not_mix_runs(other: dict[str, Any], message: str, published: dict[str, Any]) -> None:
    keep("second", published, **other)
    with pytest.raises(ValueError, match=message):
        rendered("{{ table('first', 'second') }}")
    assert rendered("{{ value('second', 'sharp', 'recovery_rate') }}")


def test_each_table_says_its_commit_and_editions(published: dict[str, Any]) -> None:
    shared = {"numpy": "2.4.6", "judge": "frame-out 2"}
    scenes = {"standard": "road-town-v2 3f0a9c1b52", "hard": "road-town-v2 77aa9c1b52"}
    contestants = {
        "sharp": {"tracker": "sharp 1 aa"},
        "centre+hold": {"tracker": "hold 3 bb", "controller": "centre 2 cc"},
    }
    made_by = {"shared": shared, "scenes": scenes, "contestants": contestants}
    keep("second", published, commit="fedcba9876", editions=made_by)
    keep("third", published, commit="fedcba9876", editions={"shared": {}, "scenes": {}, "contestants": {}})
    made = "seeds 10000:10008, commit fedcba9876"
    editions = "editions road-town-v2, frame-out 2, centre 2, hold 3, all others 1"
    page = rendered("{{ table('first') }}\n\n{{ table('second') }}\n\n{{ origin('third') }}")
    assert "Made by `python -m tools publish first`: seeds 10000:10008, commit 0123456789.\n" in page
    assert f"Made by `python -m tools publish second`: {made}, {editions}.\n" in page
    assert page.endswith(f"Made by `python -m tools publish third`: {made}.")
    both = rendered("{{ table('first', 'second') }}").splitlines()[-1]
    mine = "first: seeds 10000:10008, commit 0123456789"
    assert both == f"Made by `python -m tools publish first second`: {mine}; second: {made}, {editions}."


def test_a_tuned_tracker_beside_one_that_could_be_tuned_is_refused(
    published: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    hold = registry.entry("hold")
    monkeypatch.setitem(registry._ENTRIES, "untuned", replace(hold, name="untuned", tuned_as="untuned"))
    rows = [{"scenario": "road-town-v2", "controller": None, "tracker": name} for name in ("hold", "opencv_mil")]
    keep("second", published, budgets=budgets_of(rows))
    assert rendered("{{ table('second') }}"), "opencv_mil has nothing to tune"
    spent = budgets_of([*rows, {**rows[0], "tracker": "untuned"}])
    assert spent["trackers"]["untuned"] == {"trials": 0}
    keep("second", published, budgets=spent)
    with pytest.raises(ValueError, match=r"trackers of second tuned with one budget, got .*; untuned: trials 0"):
        rendered("{{ table('second') }}")


def test_what_a_tuned_method_took_is_not_said_of_the_same_method_as_written(monkeypatch: pytest.MonkeyPatch) -> None:
    colour = registry.entry("colour_pf")
    tuned = replace(colour, name="colour_pf_tuned", role="tuned", tuned=True)
    monkeypatch.setitem(registry._ENTRIES, "colour_pf_tuned", tuned)
    names = ("colour_pf", "colour_pf_tuned", "mosaic_graph_pf_no_roads")
    rows = [{"scenario": "road-town-v2", "controller": None, "tracker": name} for name in names]
    assert list(budgets_of(rows)["trackers"]) == ["colour_pf_tuned"]


@pytest.mark.parametrize(
    ("template", "message"),
    [
        ("{{ table('third') }}", "table: expected one that was published, got 'third'"),
        ("{{ table('first', columns=['speed']) }}", "metric: expected one of .*; got 'speed'"),
        ("{{ value('first', 'sharper', 'recovery_rate') }}", "value: expected one number of sharper in recovery_rate"),
        ("{{ paper('first') }}", "paper: expected a table of a paper's experiment, got 'first'"),
        ("{{ mean('first') }}", "template: expected one that can be read, got .*'mean' is undefined"),
        ("{{ table('first' }}", "template: expected one that can be read"),
    ],
)
def test_what_the_template_asks_for_in_vain_is_named(template: str, message: str, published: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=message):
        rendered(template)


def test_a_paper_stands_beside_our_figures(published: dict[str, Any]) -> None:
    found = {"tracker": "hold", "minus": "", "metric": "kept_rate", "counted": "kept", "paper": "it is lost"}
    numbers = {"mean": 0.08, "ci_low": 0.02, "ci_high": 0.16, "n": 8, "unit": "fraction"}
    aim = {**found, **numbers, "paper": "not in the paper; less", "expected": "below 1 %", "agrees": False}
    keep("second", published, findings=[{**found, **numbers, "expected": "at most 30 %", "agrees": True}, aim])
    assert "| `hold` | kept | it is lost | 8.0 % (2.0–16.0) | at most 30 %: yes |" in rendered("{{ paper('second') }}")
    varied = {"title": "", "words": "Varied.", "heads": ["varied", "hold: kept (%)"], "rows": [["gate × 2", "9.0"]]}
    keep("third", published, findings=[{**found, **numbers, "expected": "–", "agrees": None}], varied=varied)
    assert rendered("{{ agreed('second') }}") == "1 of 1"
    with pytest.raises(ValueError, match=r"agreed: expected a table with claims that can be judged, got 'third'"):
        rendered("{{ agreed('third') }}")
    page = rendered("{{ paper('third') }}")
    assert page.index("it is lost") < page.index("Varied.") < page.index("| gate × 2 | 9.0 |") < page.index("01234567")


def test_what_was_fitted_is_told_in_the_words_of_the_experiment(published: dict[str, Any]) -> None:
    assert rendered("{{ fitted('C') }}") == experiment_named("C").fitted != ""
    assert rendered("{{ fitted('B2') }}") == "not said."


def test_the_command_writes_all_pages(published: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    ledger.TEMPLATE.write_text("{{ value('first', 'sharp', 'recovery_rate') }}\n")
    folder = ledger.RESULTS.parent / "docs" / "results"
    folder.mkdir(parents=True)
    (folder / "earlier.md").write_text("as it was\n")
    (folder / "town.template.md").write_text("{{ value('first', 'hold', 'recovery_rate') }}\n")
    assert tools(["publish", "--render"]) == 0
    assert ledger.RESULTS.read_text() == f"{percents(entry(published, 'sharp', 'recovery_rate'))}\n"
    assert (folder / "town.md").read_text() == f"{percents(entry(published, 'hold', 'recovery_rate'))}\n"
    assert (folder / "earlier.md").read_text() == "as it was\n"
    assert capsys.readouterr().out.splitlines() == [str(ledger.RESULTS), str(folder / "town.md")]


@pytest.mark.heavy
def test_the_committed_pages_are_what_the_templates_give() -> None:
    """In a process of its own: other tests register suites and metrics here."""
    script = (
        "import json; from tools.publishing.results_page import results_pages; "
        "print(json.dumps({str(path): text for path, text in results_pages().items()}))"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    pages = json.loads(done.stdout)
    assert len(pages) >= 8
    for path, text in pages.items():
        assert text == Path(path).read_text(), f"make {path} anew: python -m tools publish --render"


def test_the_page_of_results_is_short() -> None:
    assert (ROOT / "RESULTS.md").stat().st_size <= 25_000


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_tables_of_the_committed_pages_end_before_their_prose(page: Path) -> None:
    lines = page.read_text().splitlines()
    swallowed = [after for row, after in itertools.pairwise(lines) if row.startswith("|") and after[:1] not in "|"]
    assert swallowed == []
