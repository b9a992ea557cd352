"""The list of published tables can be run as it stands."""

from __future__ import annotations

import pytest

from benchmarks.contract.rows import TEST_SPLIT
from scenarios import catalog
from tests.tools.command import tools
from tools.publishing.published import TABLES, PublishedTable
from tools.publishing.table_runs import PaperRun, run_of


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.name)
def test_every_table_names_what_exists(table: PublishedTable) -> None:
    run = run_of(table)
    if table.kind == "paper":
        assert isinstance(run, PaperRun)
        assert run.experiment.name == table.experiment
    else:
        assert table.preset in catalog.scenario(table.scenario).presets
    assert run.command.startswith(f"frameout {table.kind} ")
    whole = table.seeds.start in TEST_SPLIT and table.seeds.stop - 1 in TEST_SPLIT
    assert whole or table.kind == "speed"


def test_names_are_names_of_files() -> None:
    names = [table.name for table in TABLES]
    assert len({*names}) == len(names)
    assert all(set(name) <= set("abcdefghijklmnopqrstuvwxyz0123456789-") for name in names)


def test_scenarios_are_the_latest_versions() -> None:
    for table in TABLES:
        if table.scenario:
            assert catalog.scenario(catalog.unversioned(table.scenario)).id == table.scenario


def test_an_unknown_table_is_answered_with_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert tools(["publish", "nothing", "--dry-run"]) == 2
    error = capsys.readouterr().err
    assert all(table.name in error for table in TABLES)
