"""``python -m trackers.clients`` prints ``frameout_client.py``, to stand beside a tracker in another environment;
``python -m trackers.clients PROGRAM`` makes the environment of a program, see ``environments``, and prints its Python.
"""

import sys
from pathlib import Path

from trackers.clients.environments import made_environment
from trackers.clients.remote import PORTABLE, found_program

if len(sys.argv) > 1:
    try:
        print(made_environment(found_program(sys.argv[1], Path.cwd())))
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        sys.exit(2)
else:
    print((PORTABLE / "frameout_client.py").read_text(), end="")
