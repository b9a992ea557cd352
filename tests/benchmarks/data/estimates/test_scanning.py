"""A metric of one's own from tables alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.dataset as ds
import pytest

from benchmarks.data.estimates import block_file
from benchmarks.data.estimates.block_file import facts_in, scan
from tests.benchmarks.data.estimates.runs import TOWN, rows_in


@pytest.mark.heavy
def test_the_documented_way_gives_the_error_of_each_tracker(
    kept: Path, town: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code = str(block_file.__doc__).split("::\n")[1].replace("\n    ", "\n")
    code = code.replace("results/mine", str(kept)).replace("sets/town", town)
    told: dict[str, object] = {"np": np}
    exec(code, told)
    printed = {line.split()[0]: float(line.split()[1]) for line in capsys.readouterr().out.splitlines()[1:6]}
    assert printed["fake_knowing"] < 5.0 < printed["fake_still"]
    both = told["both"]
    assert len(both) == len(TOWN.trackers) * 2 * 60  # type: ignore[arg-type]
    # The suite's own metric, of frames on which the whole car is in the picture, is the same.
    mine = both[(both["tracker"] == "fake_still") & (both["seed"] == 3)]  # type: ignore[index]
    error_px = mine.loc[mine["state"] == "in", "error_px"].mean()
    names = ("tracker", "seed", "metric")
    rows = [row for row in rows_in(kept) if [row[name] for name in names] == ["fake_still", 3, "centre_error_px"]]
    assert [row["value"] for row in rows] == [pytest.approx(error_px, rel=1e-5)]


def test_columns_and_rows_are_chosen_before_they_are_read(kept: Path) -> None:
    silent = scan(kept).to_table(columns=["frame", "position_px"], filter=ds.field("tracker") == "fake_silent")
    assert silent.num_rows == 120
    places = np.stack(silent.to_pandas()["position_px"].to_list())
    assert np.isnan(places).all(axis=1).sum() == 80


def test_what_is_known_of_each_run_is_listed(kept: Path, tmp_path: Path) -> None:
    reasons = {facts.key.tracker: facts.runs[0].reason for _, facts in facts_in(kept)}
    assert reasons["fake_raises"] == "RuntimeError: a bug"
    assert reasons["fake_silent"] is None
    with pytest.raises(ValueError, match="estimates: expected files of"):
        scan(tmp_path)
