"""Whether our packages are the ones that Python finds: their names are words that others use too."""

from __future__ import annotations

import importlib.util
from pathlib import Path

_ROOT = Path(__file__).resolve().parents[1]


def check_own_packages() -> None:
    """Raise ImportError, with what to do, if another ``sim`` or ``trackers`` is found, or overwrote ours."""
    for name in ("sim", "trackers"):
        spec = importlib.util.find_spec(name)
        place = None if spec is None else Path(next(iter(spec.submodule_search_locations or (spec.origin or "",))))
        if place is None or place.resolve() != _ROOT / name:
            fault = f"{name}: expected Frameout's package in {_ROOT}, got {place}, which Python finds first"
            raise ImportError(f"{fault}; rename it, or start in another folder")
    # As `pip install trackers` does, roboflow's package of the same name.
    if "trackers.registry" not in (_ROOT / "trackers" / "__init__.py").read_text():
        mended = "`pip uninstall trackers`, install Frameout again, and keep the other in an environment of its own"
        raise ImportError(f"trackers: expected Frameout's package in {_ROOT}, got another's files over it; {mended}")
