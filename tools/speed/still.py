"""A tracker that does nothing: here, and by ``python still.py`` in a process of its own."""

from typing import Any


class Still:
    """Answers with the first box."""

    def __init__(self, parameters: Any, rng: Any) -> None:
        pass

    def initialise(self, observation: Any, box_xyxy: Any) -> None:
        """See ``trackers.Tracker``."""
        self._box_xyxy = box_xyxy

    def update(self, observation: Any) -> Any:
        """See ``trackers.Tracker``."""
        return Estimate(0.5 * (self._box_xyxy[:2] + self._box_xyxy[2:]), self._box_xyxy)


if __name__ == "__main__":
    from frameout_client import Estimate, serve

    serve(Still)
else:
    from trackers.types import Estimate
