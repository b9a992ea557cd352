"""What ``--modules tests.toy_scene.register`` makes known: the scene with its env, its suite, trackers, controllers."""

from scenarios import catalog
from tests.toy_scene import controller, suite, tracker

__all__ = ["controller", "suite", "tracker"]

catalog.register(
    catalog.Entry("toy-yard-v1", "tests.toy_scene.scenario:TOY_YARD", "frameout/ToyYard-v1", "warm_bodies")
)
