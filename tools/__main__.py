"""``python -m tools``: what makes the published tables and the values that trackers ship, in a checkout."""

from __future__ import annotations

import sys

from benchmarks.cli.main import Program, main

TOOLS = Program(
    "python -m tools",
    {
        "publish": ("tools.publish:Publish", "make and check the published tables, write their pages"),
        "speed": ("tools.time_speed:Speed", "time rendering against TinyRenderer, and steps of the envs"),
        "scale": ("tools.scale:Scale", "compute what large sets cost, and time the handling of 100,000 episodes"),
        "learn-colours": ("tools.learn.colours:LearnColours", "learn colour models of road and other ground"),
        "learn-swims": ("tools.learn.swims:LearnSwims", "learn from simulated swims what gap methods ship"),
        "learn-swings": ("tools.learn.swings:LearnSwings", "learn how swings of a camera in gusts go on"),
        "learn-alarms": ("tools.learn.alarms:LearnAlarms", "learn from episodes what baselines of alarms ship"),
    },
    "Tools of the project itself, which users of the package do not need.",
)

if __name__ == "__main__":
    sys.exit(main(program=TOOLS))
