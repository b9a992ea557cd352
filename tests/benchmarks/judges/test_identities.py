"""HOTA, ID and CLEAR scores are TrackEval's, as recorded by ``record_trackeval.py``."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.judges import identities
from benchmarks.judges.identities import Pairing, clear_counts, hota, identity_counts, numbered, pairing
from tests.benchmarks.judges.record_trackeval import FILE, random_tracks, sequences

RECORDED = json.loads(FILE.read_text())


def paired(sequence: Any, zero_px: float = RECORDED["zero_px"]) -> list[Pairing]:
    frames = []
    count = 1 + max((one[0] for frame in sequence["targets"] for one in frame), default=-1)
    for targets, tracks in zip(sequence["targets"], sequence["tracks"], strict=True):
        places = np.full((count, 2), np.nan)
        for name, x, y in targets:
            places[name] = x, y
        said = np.array(tracks, float).reshape(-1, 3)
        frames.append(pairing(places, said[:, 0].astype(int), said[:, 1:], zero_px))
    return numbered(frames)


def test_the_recorded_sequences_are_those_of_the_recording_script() -> None:
    made = sequences()
    for name, entry in RECORDED["sequences"].items():
        assert {side: entry[side] for side in ("targets", "tracks")} == json.loads(json.dumps(made[name]))


@pytest.mark.parametrize("name", RECORDED["sequences"])
def test_scores_are_those_of_trackeval(name: str) -> None:
    sequence = RECORDED["sequences"][name]
    expected, frames = sequence["result"], paired(sequence)
    ids, clear = identity_counts(frames), clear_counts(frames)
    assert (ids.right, ids.missed, ids.false) == tuple(expected[each] for each in ("IDTP", "IDFN", "IDFP"))
    found = (clear.found, clear.missed, clear.false, clear.switches)
    assert found == tuple(expected[each] for each in ("CLR_TP", "CLR_FN", "CLR_FP", "IDSW"))
    scores = (hota(frames), ids.idf1, clear.mota)
    assert scores == pytest.approx(tuple(expected[each] for each in ("HOTA", "IDF1", "MOTA")), abs=1e-9)


def test_the_recording_can_tell_scores_apart() -> None:
    results = [entry["result"] for entry in RECORDED["sequences"].values()]
    assert RECORDED["trackeval"] == "1.3.0"
    assert max(result["IDSW"] for result in results) > 50
    assert {result["IDTP"] == result["CLR_TP"] for result in results} == {True, False}


@given(st.integers(0, 10_000), st.permutations(range(12)))
def test_names_of_tracks_do_not_matter_and_the_truth_is_perfect(seed: int, order: list[int]) -> None:
    sequence = random_tracks(seed, 4, 12, 3.0, 0.1, 0.1)
    renamed = {one[0] for frame in sequence["tracks"] for one in frame}
    names = dict(zip(sorted(renamed), [100 + place for place in order] * 10, strict=False))
    other = [[[names[one[0]], *one[1:]] for one in frame] for frame in sequence["tracks"]]
    if len(set(names.values())) == len(names):
        first, second = paired(sequence), paired({**sequence, "tracks": other})
        assert identity_counts(first) == identity_counts(second)
        assert clear_counts(first).switches == clear_counts(second).switches
        assert hota(first) == pytest.approx(hota(second))
    perfect = paired({**sequence, "tracks": sequence["targets"]})
    if any(sequence["targets"]):
        assert (hota(perfect), identity_counts(perfect).idf1, clear_counts(perfect).mota) == (1.0, 1.0, 1.0)


def test_no_frame_at_all_has_no_score() -> None:
    empty = numbered([pairing(np.full((2, 2), np.nan), np.empty(0, int), np.empty((0, 2)), 10.0)] * 3)
    assert hota(empty) == 0.0
    assert identity_counts(empty) == identities.IdentityCounts(0, 0, 0)
    assert clear_counts(empty) == identities.ClearCounts(0, 0, 0, 0)
