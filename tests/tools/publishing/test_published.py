"""The list of published tables can be run as it stands, and the committed files are those of its tables."""

from __future__ import annotations

import json

import pytest

from benchmarks.contract.rows import TEST_SPLIT
from scenarios import catalog
from tools.publishing import ledger
from tools.publishing.table_files import read_rows_of
from tools.publishing.tables import TABLES, BenchTable, PaperTable, PublishedTable, SpeedTable

ROOM_BYTES = 20_000_000
"""For the compressed rows of all tables together; fewer seeds take less."""


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.name)
def test_every_table_names_what_exists(table: PublishedTable) -> None:
    if isinstance(table, PaperTable):
        assert table.paper.name == table.experiment
    else:
        assert isinstance(table, BenchTable | SpeedTable)
        latest = catalog.id_of(catalog.unversioned(table.scenario))
        assert table.scenario in {latest, *(each.id for each in catalog.entries() if each.is_next)}, "an old version"
        assert table.preset in catalog.scenario(table.scenario).presets
    if isinstance(table, BenchTable):
        # Figures that no seed makes reproducible cannot be checked.
        assert all(tracker.reproducible for tracker in table.experiment.trackers.values())
    assert isinstance(table, SpeedTable) or {table.seeds.start, table.seeds.stop - 1} <= {*TEST_SPLIT}


def test_names_are_names_of_files() -> None:
    names = [table.name for table in TABLES]
    assert len({*names}) == len(names)
    assert all(set(name) <= set("abcdefghijklmnopqrstuvwxyz0123456789-") for name in names)


@pytest.mark.heavy
def test_the_committed_files_are_those_of_the_list() -> None:
    files = sorted(ledger.TABLES_FOLDER.glob("*.json"))
    commands = {table.name: table.command for table in TABLES}
    assert {file.stem for file in files} == commands.keys()
    for file in files:
        table, rows = json.loads(file.read_text()), read_rows_of(file.stem)
        assert table["command"] == commands[file.stem]
        assert (table["rows"] or {"count": 0})["count"] == sum(map(len, rows.values())), file.name
    assert sum(file.stat().st_size for file in ledger.TABLES_FOLDER.glob("*.xz")) <= ROOM_BYTES


def test_the_ledger_can_be_read() -> None:
    keys = {"command", "commit", "split", "seeds", "why"}
    assert all(set(json.loads(line)) == keys for line in ledger.LEDGER.read_text().splitlines())
