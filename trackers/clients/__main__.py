"""``python -m trackers.clients`` prints ``frameout_client.py``, to stand beside a tracker in another environment."""

from pathlib import Path

print((Path(__file__).parent / "frameout_client.py").read_text(), end="")
