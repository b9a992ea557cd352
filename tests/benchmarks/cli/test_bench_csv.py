"""``frameout bench --csv``: the table that Python gives, as a file or on stdout."""

from __future__ import annotations

import io
from pathlib import Path

import pandas as pd
import pytest

from benchmarks import Results
from benchmarks.cli.main import main

pytestmark = pytest.mark.usefixtures("fake_suite")


def bench(out: Path, *more: str) -> int:
    return main(["bench", "--workers", "0", "--seeds", "0:1", "--trackers", "fake_still", "--out", str(out), *more])


def test_a_file_holds_the_table_of_python_and_the_leaderboard_stays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "tables" / "rows.csv"
    assert bench(tmp_path / "out", "--csv", str(file)) == 0
    assert "fake_still" in capsys.readouterr().out
    pd.testing.assert_frame_equal(pd.read_csv(file), read_again(Results(tmp_path / "out").rows()))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--csv", "."), "csv: expected a file, got the folder '.'"),
        (("--csv", "/dev/null/rows.csv"), "csv: expected a folder that can be written, got '/dev/null'"),
    ],
)
def test_what_cannot_be_written_is_said_before_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], message: str
) -> None:
    assert bench(tmp_path / "out", *words) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def read_again(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table as it comes out of a file, whose numbers have no types."""
    return pd.read_csv(io.StringIO(table.to_csv(index=False)))
