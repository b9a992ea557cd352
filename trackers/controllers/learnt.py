"""Trained policies that ship, one for a carrier: ``trackers/policies/CARRIER.json``, with a card beside it."""

from __future__ import annotations

from pathlib import Path

from trackers.controllers.catalogue import register_controller
from trackers.controllers.policy import PolicyController, PolicyParameters
from trackers.registry import NoParameters

FOLDER = Path(__file__).parents[1] / "policies"


@register_controller(
    "learnt",
    role="policy",
    carrier="helicopter",
    edition=2,
    summary="corrects reentry by a network that remembers, trained without pictures",
)
class LearntHelicopterController(PolicyController):
    """Steers as the policy of the helicopter says."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters) -> None:
        super().__init__(PolicyParameters(str(FOLDER / "helicopter.json")))
