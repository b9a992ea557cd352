"""``shoal_chain``, our own: tracklets of fish, linked by motion and looks, with gaps bridged."""

from __future__ import annotations

import numpy as np

from trackers.fish_chain.chain import Chain, ChainParameters
from trackers.registry import register, register_variant
from trackers.swimmer.method import SwimGaps


@register(
    "shoal_chain",
    role="ours",
    summary="detection and posture, tracklets, links by motion and looks within 30 frames",
    suites=("fish",),
)
class ShoalChain(Chain):
    """A ``RevisingTracker`` and ``BridgingTracker`` of all fish in a tank."""

    Parameters = ChainParameters

    def __init__(self, parameters: ChainParameters, rng: np.random.Generator) -> None:
        super().__init__(parameters, SwimGaps())
        # The chain's own one has learnt from this video; this one is taught by those that use it.
        self.gap_method = SwimGaps()


@register(
    "shoal_chain_shipped",
    role="variant",
    summary="gaps are bridged with the shipped weights, which learn nothing from the tracks at hand",
    suites=("fish",),
)
class ShippedShoalChain(Chain):
    """``ShoalChain`` whose bridging of gaps never learns from the video."""

    Parameters = ChainParameters

    def __init__(self, parameters: ChainParameters, rng: np.random.Generator) -> None:
        super().__init__(parameters, SwimGaps(learns=False))
        self.gap_method = SwimGaps(learns=False)


register_variant("shoal_chain_offline", "shoal_chain", summary="links decided after the whole video", offline=True)
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
