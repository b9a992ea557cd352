"""Numbers, units and heads of columns in words."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.contract import text as numbers
from benchmarks.contract.suite import suite, suites
from benchmarks.show import tables
from benchmarks.show.definitions import metrics_of

FRAME_OUT = suite("frame-out")


@given(value=st.floats(-1e4, 1e4, allow_nan=False), signed=st.booleans())
def test_numbers_keep_their_value(value: float, signed: bool) -> None:
    text = numbers.number_text(value, "m", signed=signed)
    shown = float(text.replace("\u2212", "-"))
    assert shown == pytest.approx(value, abs=0.51 if abs(value) >= 99.9 else 0.051)
    assert "-" not in text


def test_numbers_in_words() -> None:
    assert numbers.number_text(0.934, "fraction") == "93.4"
    assert numbers.number_text(None, "m") == "–"
    assert numbers.number_text(-0.0001, "m", signed=True) == "0.00"
    assert numbers.ranges_text([3, 1, 2, 9, 10_000, 10_001]) == "1–3, 9, 10,000–10,001"


def test_a_head_says_no_unit_twice() -> None:
    for name in suites():
        for metric in metrics_of(suite(name)):
            words = tables.column_of(metric).head.replace("(", "").replace(")", "").split()
            assert all(first != second for first, second in itertools.pairwise(words)), words
            half = [words[k : k + 2] for k in range(len(words) - 1)]
            assert all(half[k] != half[k + 2] for k in range(len(half) - 2)), words
    assert tables.column_of(FRAME_OUT.metric("time_to_recover_frames")).head == "time to recover (frames) ↓"
    assert tables.column_of(FRAME_OUT.metric("offscreen_error_car_lengths")).head == "offscreen error (car lengths) ↓"
    assert tables.column_of(FRAME_OUT.metric("precision_20_px")).head == "precision 20 px (%) ↑"


def test_one_thing_is_no_plural_and_one_length_no_range() -> None:
    assert [numbers.counted(count, "loss", "losses") for count in (0, 1, 2)] == ["no losses", "1 loss", "2 losses"]
    assert numbers.counted(2, "gap") == "2 gaps"
    assert [numbers.lengths_text(each) for each in ([3, 8, 5], [6, 6], [1])] == ["3 to 8 frames", "6 frames", "1 frame"]
