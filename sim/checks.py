"""Checks of what a user configures."""

from __future__ import annotations


def check(name: str, good: bool, expected: str, got: object) -> None:
    """Raise ValueError that names the parameter, what was expected and what came, unless ``good``."""
    if not good:
        raise ValueError(f"{name}: expected {expected}, got {got}")
