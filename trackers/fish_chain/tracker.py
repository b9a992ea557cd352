"""``shoal_chain``, our own: tracklets of fish, linked by motion and looks, with gaps bridged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trackers.fish_chain.chain import Chain, ChainParameters
from trackers.registry import register, register_variant
from trackers.swimmer.method import SwimGaps


@dataclass(frozen=True)
class ShoalChainParameters(ChainParameters):
    """Parameters of ``shoal_chain``.

    Attributes:
        learns: if False, gaps are bridged with the shipped weights, which learn nothing from the tracks at hand.
    """

    learns: bool = True


@register(
    "shoal_chain",
    role="ours",
    summary="detection and posture, tracklets, links by motion and looks within 30 frames",
    suites=("fish",),
)
class ShoalChain(Chain):
    """A ``RevisingTracker`` and ``BridgingTracker`` of all fish in a tank."""

    Parameters = ShoalChainParameters

    def __init__(self, parameters: ShoalChainParameters, rng: np.random.Generator) -> None:
        # The chain's own one learns from this video; the other one is taught by those that use it.
        own, self.gap_method = (SwimGaps(parameters.use_posture, learns=parameters.learns) for _ in range(2))
        super().__init__(parameters, own)


register_variant("shoal_chain_offline", "shoal_chain", summary="links decided after the whole video", offline=True)
register_variant("shoal_chain_shipped", "shoal_chain", summary="gaps bridged as shipped, nothing learnt", learns=False)
register_variant("shoal_chain_no_looks", "shoal_chain", summary="links without appearance", use_appearance=False)
register_variant("shoal_chain_no_motion", "shoal_chain", summary="links by appearance alone", use_motion=False)
register_variant("shoal_chain_no_posture", "shoal_chain", summary="links without posture", use_posture=False)
register_variant(
    "shoal_chain_motion",
    "shoal_chain",
    summary="links by places alone: neither looks nor posture",
    use_appearance=False,
    use_posture=False,
)
