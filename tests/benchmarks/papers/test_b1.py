"""Paper experiment B.1: claims are judged rightly, and a run leaves rows, plots, pictures and page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.papers import b1
from benchmarks.papers.b1 import CONDITIONS, CURVES, EXPERIMENT, photograph
from benchmarks.papers.measured import MeasuredExperiment
from benchmarks.run.records import Row, append_block, read_blocks
from scenarios.scenario import RendererName
from scenarios.stereo_follow.scenario import STEREO_FOLLOW

ILLUMINANCES = 9


@pytest.fixture(scope="module")
def block() -> list[Row]:
    return EXPERIMENT.block(3, "raster")


def test_rows_hold_every_curve_and_claim(block):
    values = {row["metric"]: row["value"] for row in block}
    for condition in CONDITIONS:
        for curve in CURVES:
            assert len(values[f"{condition.name}_{curve}"]) == ILLUMINANCES
    for finding in EXPERIMENT.findings(block):
        assert finding.mean == values[finding.claim.metric]
        # It comes out as the paper says.
        assert finding.agrees is not False, finding
    assert block[-1]["metric"] == "frames"
    # The template is the brightest picture itself.
    assert values["I_dissimilarity"][0] == pytest.approx(0.0, abs=1e-6)
    assert max(values["II_gain"]) == max(values["III_white_balance"]) == 0.0


def test_conditions_differ_in_what_the_camera_holds_alone():
    taken = {condition.name: list(photograph(condition, 3)) for condition in CONDITIONS}
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


def test_a_claim_is_judged_by_its_bound(block):
    def row(metric: str, value: float, seed: int) -> Row:
        return {**block[0], "metric": metric, "value": value, "seed": seed}

    rows = [row("I_change_follows", value, seed) for seed, value in enumerate((0.8, 0.98))]
    rows += [row("gain_before_longest_shutter", value, seed) for seed, value in enumerate((0.0, 0.2))]
    others = {claim.metric for claim in EXPERIMENT.claims} - {row["metric"] for row in rows}
    rows += [row(metric, 0.95, 0) for metric in others]
    found = {each.claim.metric: each for each in EXPERIMENT.findings(rows)}
    assert found["I_change_follows"].mean == pytest.approx(0.89)
    assert not found["I_change_follows"].agrees
    assert (found["I_change_follows"].ci_low, found["I_change_follows"].ci_high) == pytest.approx((0.8, 0.98))
    assert not found["gain_before_longest_shutter"].agrees
    assert found["II_white_balance_follows"].agrees
    assert found["I_change_proportional"].agrees is None


def test_a_run_leaves_rows_pictures_and_page_and_keeps_the_other_renderers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In smaller pictures, which PyBullet's renderer draws sooner."""
    small = replace(STEREO_FOLLOW.presets[EXPERIMENT.preset], width_px=160, height_px=120)
    monkeypatch.setitem(STEREO_FOLLOW.presets, EXPERIMENT.preset, small)
    for renderer in ("raster", "pybullet"):
        b1.run(tmp_path, range(1), renderer, 1)
    assert "paper.html" in capsys.readouterr().out
    assert {key.renderer for key in read_blocks(tmp_path)} == {"raster", "pybullet"}
    page = (tmp_path / "paper.html").read_text()
    assert "frameout paper B1 --seeds 0:1 --renderer pybullet" in page
    for claim in EXPERIMENT.claims:
        assert claim.words in page
    assert page.count("<svg") == len(CONDITIONS)
    height, width = cv2.imread(str(tmp_path / "pictures" / "paper-b1-raster.jpg")).shape[:2]
    assert width / ILLUMINANCES > height / len(CONDITIONS)


def test_a_stopped_run_goes_on_and_what_other_code_made_is_made_again(
    tmp_path: Path, block: list[Row], monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = []

    def block_of(self: MeasuredExperiment, seed: int, renderer: RendererName) -> list[Row]:
        measured.append(seed)
        return [{**row, "seed": seed, "renderer": renderer} for row in block]

    monkeypatch.setattr(MeasuredExperiment, "block", block_of)
    append_block(tmp_path, [{**row, "seed": 5} for row in block])
    append_block(tmp_path, [{**row, "seed": 6, "versions": {"experiment": "older"}} for row in block])
    rows = EXPERIMENT.run(tmp_path, range(4, 8), "raster", 1)
    assert measured == [4, 6, 7]
    assert sorted({row["seed"] for row in rows}) == [4, 5, 6, 7]


@pytest.mark.parametrize(
    ("stranger", "came"),
    [({"suite": "frame-out", "preset": "standard"}, "frame-out standard, seed 3"), ({"seed": 9}, "paper-b1, seed 9")],
)
def test_a_folder_with_other_rows_is_refused_and_left_alone(
    tmp_path: Path, block: list[Row], stranger: Row, came: str
) -> None:
    append_block(tmp_path, [{**row, **stranger} for row in block])
    before = (tmp_path / "records.jsonl").read_bytes()
    with pytest.raises(ValueError, match=rf"out: expected a folder with no rows but rows of paper B1 .*{came}"):
        EXPERIMENT.run(tmp_path, range(3, 4), "raster", 1)
    assert (tmp_path / "records.jsonl").read_bytes() == before
