"""The head of a README, as the Hugging Face Hub reads it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml


def head_of(readme: Path) -> dict[str, Any]:
    """Return the YAML between the first two lines of dashes."""
    before, head, _ = readme.read_text(encoding="utf-8").split("---\n", 2)
    assert before == ""
    found: dict[str, Any] = yaml.safe_load(head)
    return found
