"""Paper experiment B.1: claims are judged rightly, and a run leaves rows, plots, pictures and page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.contract.rows import Row, read_blocks
from benchmarks.papers import b1
from benchmarks.papers.b1 import CONDITIONS, CURVES
from benchmarks.papers.camera_experiment import CameraExperiment, photograph
from benchmarks.papers.experiment import experiment_named, findings
from benchmarks.papers.repeat import repeat
from benchmarks.run.result_folder import append_block
from scenarios.paper_sheet.scenario import PAPER_SHEET
from scenarios.scenario import RendererName

EXPERIMENT = experiment_named("B1")
ILLUMINANCES = 9


@pytest.fixture(scope="module")
def block() -> list[Row]:
    return EXPERIMENT.block(3, "raster")


@pytest.mark.heavy
def test_rows_hold_every_curve_and_claim(block):
    values = {row["metric"]: row["value"] for row in block}
    for condition in CONDITIONS:
        for curve in CURVES:
            assert len(values[f"{condition}_{curve}"]) == ILLUMINANCES
    for finding in findings(EXPERIMENT, block):
        assert finding.mean == values[finding.claim.metric]
        # It agrees with the paper.
        assert finding.agrees is not False, finding
    assert block[-1]["metric"] == "frames"
    # The template is the brightest picture itself.
    assert values["I_dissimilarity"][0] == pytest.approx(0.0, abs=1e-6)
    assert max(values["II_gain"]) == max(values["III_white_balance"]) == 0.0


@pytest.mark.heavy
@pytest.mark.parametrize("unit", [1.0, 1023.0])
def test_a_wrong_scale_of_p_c_is_noticed(unit: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(b1, "_UNIT", unit)
    found = {each.claim.metric: each.agrees for each in findings(EXPERIMENT, EXPERIMENT.block(3, "raster"))}
    if unit > b1.StereoColourParameters().white_balance_unit:
        assert found["I_change_follows"], "a rank correlation does not notice"
    assert not (found["I_colour_change_largest"] and found["II_colour_change_off"])


@pytest.mark.heavy
def test_p_c_and_p_l_are_shown_at_every_illuminance(tmp_path: Path, block: list[Row]) -> None:
    table = EXPERIMENT.sensitivity(tmp_path, block, range(3, 4), "raster")
    assert table is not None
    _, dissimilarity, brightness, colour, as_registers, as_shares = (
        [float(value) for value in column] for column in zip(*table.rows, strict=True)
    )
    assert len(table.rows) == ILLUMINANCES
    assert colour == sorted(colour)
    assert (colour[0], brightness[0], dissimilarity[0]) == (0.0, 0.0, 0.0)
    assert 0.9 < colour[-1] <= brightness[-1] == as_registers[1] == 1.0
    assert as_shares[-1] < 0.13


@pytest.mark.heavy
def test_conditions_differ_in_what_the_camera_holds_alone():
    taken = {name: list(photograph(EXPERIMENT.preset, 3, **held)) for name, held in CONDITIONS.items()}
    first = taken["I"][0]
    for name, pictures in taken.items():
        np.testing.assert_array_equal(pictures[0].image_rgb, first.image_rgb)
        np.testing.assert_allclose(
            [p.illuminance_lx for p in pictures], [p.illuminance_lx for p in taken["I"]], err_msg=name
        )
    exposures = {name: {(p.registers.shutter, p.registers.gain) for p in taken[name]} for name in taken}
    balances = {name: {(p.registers.red, p.registers.blue) for p in taken[name]} for name in taken}
    assert [len(exposures[name]) for name in taken] == [ILLUMINANCES, 1, ILLUMINANCES]
    assert [len(balances[name]) for name in taken] == [ILLUMINANCES, ILLUMINANCES, 1]


@pytest.mark.heavy
def test_a_run_leaves_rows_pictures_and_page_and_keeps_the_other_renderers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In smaller pictures, which PyBullet's renderer draws faster."""
    small = replace(PAPER_SHEET.presets[EXPERIMENT.preset], width_px=160, height_px=120)
    monkeypatch.setitem(PAPER_SHEET.presets, EXPERIMENT.preset, small)
    for renderer in ("raster", "pybullet"):
        repeat(EXPERIMENT, tmp_path, range(1), renderer, 0)
    assert "paper.html" in capsys.readouterr().out
    assert {key.renderer for key in read_blocks(tmp_path)} == {"raster", "pybullet"}
    page = (tmp_path / "paper.html").read_text()
    assert "frameout paper B1 --seeds 0:1 --renderer pybullet" in page
    assert "`" not in page
    assert "Paper B, a person followed with a stereo camera" in page
    for claim in EXPERIMENT.claims:
        assert claim.words in page
    assert "P_c and P_l at each illuminance" in page
    assert page.count("<svg") == len(CONDITIONS)
    height, width = cv2.imread(str(tmp_path / "pictures" / "paper-b1-raster.jpg")).shape[:2]
    assert width / ILLUMINANCES > height / len(CONDITIONS)


def test_a_stopped_run_goes_on_and_what_another_edition_made_is_made_again(
    tmp_path: Path, block: list[Row], monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = []

    def block_of(self: CameraExperiment, seed: int, renderer: RendererName) -> list[Row]:
        measured.append(seed)
        return [{**row, "seed": seed, "renderer": renderer} for row in block]

    monkeypatch.setattr(CameraExperiment, "block", block_of)
    append_block(tmp_path, [{**row, "seed": 5} for row in block])
    append_block(tmp_path, [{**row, "seed": 6, "editions": {"experiment": "older"}} for row in block])
    told: list[tuple[int, int]] = []
    (moved,) = EXPERIMENT.run(tmp_path, range(4, 8), "raster", 0, lambda done, of: told.append((done, of)))
    assert "were moved to" in moved
    assert measured == [4, 6, 7]
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert sorted({row["seed"] for row in EXPERIMENT.rows_in(tmp_path)}) == [4, 5, 6, 7]


def test_a_folder_with_other_seeds_is_refused_and_left_alone(tmp_path: Path, block: list[Row]) -> None:
    append_block(tmp_path, [{**row, "seed": 9} for row in block])
    before = (tmp_path / "records.jsonl").read_bytes()
    with pytest.raises(ValueError, match=r"out: expected a folder with no seeds but 3:4, .*, which holds seed 9"):
        EXPERIMENT.run(tmp_path, range(3, 4), "raster", 0, lambda done, of: None)
    assert (tmp_path / "records.jsonl").read_bytes() == before


@pytest.mark.parametrize(
    "stranger", [{"suite": "frame-out"}, {"preset": "standard"}, {"scenario": "stereo-follow-v2"}, {"controller": "x"}]
)
def test_rows_of_something_else_stay_in_the_folder_and_count_for_nothing(
    tmp_path: Path, block: list[Row], stranger: Row
) -> None:
    for rows in ([{**row, **stranger} for row in block], block):
        append_block(tmp_path, rows)
    assert EXPERIMENT.run(tmp_path, range(3, 4), "raster", 0, lambda done, of: None) == []
    assert len(read_blocks(tmp_path)) == 2
    assert EXPERIMENT.rows_in(tmp_path) == block
