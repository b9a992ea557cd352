"""Paper experiment B.3: its figures on development seeds, which hold its verdicts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.papers.experiment import experiment_named, findings
from scenarios.catalog import scenario
from scenarios.stereo_follow.plan import make_plan

EXPERIMENT = experiment_named("B3")
SEEDS = range(2)
F_MEASURES = {
    ("", "stereo_wb"): 0.946,
    ("", "stereo_wb_shutter_gain"): 0.947,
    ("paper-b3-dressed-apart", "stereo_wb"): 0.868,
    ("paper-b3-dressed-apart", "stereo_wb_shutter_gain"): 0.896,
}
"""Preset ("": the experiment's) and method → F-measure on ``SEEDS``."""


@pytest.mark.heavy
def test_people_dressed_apart_walk_the_same_drives():
    presets = scenario(EXPERIMENT.scenario).presets
    uniform, apart = (make_plan(presets[name], 3, closed_loop=False) for name in EXPERIMENT.presets)
    assert (uniform.crowd.robot_m == apart.crowd.robot_m).all()
    for one, other in zip(uniform.crowd.walks, apart.crowd.walks, strict=True):
        assert (one.place_m == other.place_m).all()
    for group, strength in uniform.light.strengths.items():
        assert (strength == apart.light.strengths[group]).all()
    assert len({look.top_rgb for look in uniform.looks}) == 1
    assert all(look.top_rgb != apart.looks[0].top_rgb for look in apart.looks[1:])


def test_the_page_says_that_one_uniform_removes_the_premise():
    assert "one uniform, which removes that premise" in " ".join(EXPERIMENT.setting.split())


@pytest.mark.heavy
def test_both_methods_score_as_they_did(tmp_path: Path) -> None:
    alone = replace(EXPERIMENT, beside=(), robustness=None)
    alone.run(tmp_path, SEEDS, "raster", 2, lambda done, of: None)
    found = {
        (each.claim.preset, each.claim.tracker): each.mean
        for each in findings(alone, alone.rows_in(tmp_path))
        if each.claim.metric == "f_measure"
    }
    assert found == {which: pytest.approx(share, abs=0.03) for which, share in F_MEASURES.items()}
