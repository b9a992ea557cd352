"""Names in rows of a tracker with another value of one parameter: ``colour_pf[particles=50]``."""

from __future__ import annotations

import re
from typing import NamedTuple

_NAME = re.compile(r"([^\[\]]+)\[(\w+)=([^\[\]=]+)\]")


class Varied(NamedTuple):
    """A tracker's name, the parameter that has another value, and that value as text."""

    base: str
    parameter: str
    value: str

    @property
    def curve(self) -> str:
        """Name of all values of the parameter together: ``colour_pf[particles]``."""
        return f"{self.base}[{self.parameter}]"

    def __str__(self) -> str:
        return f"{self.base}[{self.parameter}={self.value}]"


def varied(name: str) -> Varied | None:
    """Return what a tracker's name in rows says of a parameter; None if it says nothing."""
    match = _NAME.fullmatch(name)
    return None if match is None else Varied(*match.groups())


def base_of(name: str) -> str:
    """Return a tracker's name without the value of a parameter."""
    found = varied(name)
    return name if found is None else found.base
