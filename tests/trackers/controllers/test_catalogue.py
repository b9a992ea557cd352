"""Controllers by name and carrier."""

from __future__ import annotations

import pytest

from trackers.controllers.catalogue import controller_entry, steers_instead


def test_a_controller_of_another_carrier_is_told_what_it_steers() -> None:
    assert steers_instead("reentry") == ", which steers a helicopter or a robot"
    assert steers_instead("nobody") == ""
    with pytest.raises(ValueError, match=r"got 'reentry', which steers a helicopter or a robot$"):
        controller_entry("reentry", "tank-head")
