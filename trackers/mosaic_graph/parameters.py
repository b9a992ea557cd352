"""Parameters of ``mosaic_graph_pf``."""

from __future__ import annotations

from dataclasses import dataclass

from trackers.registry import tunable


@dataclass(frozen=True)
class MosaicGraphParameters:
    """Parameters of ``mosaic_graph_pf``; the ``use_`` ones switch parts off, for ablation.

    Without a measured pose ``particles``, ``use_filter``, ``use_negative_information`` and ``use_redetection`` count.

    Attributes:
        particles: number of particles.
        candidates: number of boxes from the whole picture, in addition to the expected places.
        detection_probability: of a target in full view, given that it was missed in the picture before.
        detection_deviation_m: standard deviation of a detection.
        surprise: prior probability that the target is where no particle is, after a long time out of view.
        renewal: prior probability in each picture that it moves as no particle does.
        urge_spread_mps2, speed_noise, cruise_spread_mps, cruise_rate, turn_weight, leave_rate, curve_spread_per_m,
            unseen_turns_per_m: see ``Habits``.
        use_filter: if False, a map is made without a measured pose too, of ground that is taken to lie straight below.
    """

    particles: int = 1000
    candidates: int = 6
    detection_probability: float = tunable(0.6, 0.2, 0.95)
    detection_deviation_m: float = tunable(0.25, 0.1, 1.5, log=True)
    surprise: float = tunable(0.2, 0.001, 0.5, log=True)
    renewal: float = tunable(0.03, 0.001, 0.2, log=True)
    urge_spread_mps2: float = tunable(1.5, 0.2, 3.0, log=True)
    speed_noise: float = tunable(0.7, 0.2, 2.0, log=True)
    cruise_spread_mps: float = tunable(2.5, 0.5, 5.0)
    cruise_rate: float = tunable(0.25, 0.05, 1.0, log=True)
    turn_weight: float = tunable(0.7, 0.1, 2.0, log=True)
    leave_rate: float = tunable(0.05, 0.002, 0.2, log=True)
    curve_spread_per_m: float = tunable(0.02, 0.003, 0.1, log=True)
    unseen_turns_per_m: float = tunable(0.01, 0.001, 0.03, log=True)
    use_ego: bool = True
    use_filter: bool = True
    use_mosaic: bool = True
    use_roads: bool = True
    use_negative_information: bool = True
    use_redetection: bool = True
