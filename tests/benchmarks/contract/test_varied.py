"""A name that says another value of a parameter is read as it was written."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from benchmarks.contract.varied import Varied, base_of, varied

NAMES = st.from_regex(r"[a-z_][a-z0-9_]{0,12}", fullmatch=True)
VALUES = st.one_of(st.integers().map(str), st.floats(allow_nan=False).map(str), st.sampled_from(["true", "fast"]))


@given(base=NAMES, parameter=NAMES, value=VALUES)
def test_a_name_is_read_as_it_was_written(base: str, parameter: str, value: str) -> None:
    written = str(Varied(base, parameter, value))
    assert varied(written) == (base, parameter, value)
    assert base_of(written) == base
    assert Varied(base, parameter, value).curve == f"{base}[{parameter}]"


@given(name=NAMES)
def test_a_plain_name_says_nothing_of_a_parameter(name: str) -> None:
    assert varied(name) is None
    assert base_of(name) == name
