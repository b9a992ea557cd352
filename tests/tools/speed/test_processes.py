from __future__ import annotations

from tests import fakes_scenario  # noqa: F401
from tools.speed.processes import measure_process


def test_a_process_costs_little_a_frame() -> None:
    made = measure_process("fake-town", "tiny", 40, 0)
    assert {each.unit for each in made.values()} == {"ms"}
    # Far more than it takes, for loaded machines.
    assert 0.0 < made["process_cpu_ms"].above < 5.0
    assert -1.0 < made["process_wall_ms"].above < 20.0
