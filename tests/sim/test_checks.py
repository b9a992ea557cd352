"""A misspelt name is answered with the nearest known one."""

from __future__ import annotations

import pytest

from sim.checks import check_choice


@pytest.mark.parametrize(
    ("given", "why", "ends"),
    [
        ("colour_fp", "", r"got 'colour_fp' \(did you mean colour_pf\?\)$"),
        ("owl", "", "got 'owl'$"),
        ("colour", "", r"got 'colour' \(did you mean colour_pf\?\)$"),
        ("", "", "got ''$"),
        ("colour_fp", ", which is of suite fish", "got 'colour_fp', which is of suite fish$"),
    ],
)
def test_the_nearest_name_is_suggested(given: str, why: str, ends: str) -> None:
    check_choice("tracker", "hold", ["hold", "colour_pf"])
    with pytest.raises(ValueError, match=f"^tracker: expected one of hold, colour_pf; {ends}"):
        check_choice("tracker", given, ["hold", "colour_pf"], why=why)
