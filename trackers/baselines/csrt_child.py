"""OpenCV's CSRT behind a pipe: runs in an interpreter of its own, with opencv-contrib-python-headless and numpy alone.

On stdin come requests, on stdout go replies, both little-endian and of fixed form:

* greeting, once, from here: ``HELLO``, then OpenCV's version in ASCII, ``VERSION_BYTES`` long, filled up with spaces;
* request: ``REQUEST`` = kind (``i`` = start on a box, ``u`` = next picture), width and height of the picture, and the
  box's x, y, width and height (only read for ``i``); then height x width x 3 bytes RGB, row by row;
* reply: ``REPLY`` = whether the target was found, the box's x, y, width and height, and the CPU time in seconds that
  this process spent on the picture.

It ends when stdin does.
"""

import struct
import sys
import time

HELLO = b"frameout-csrt-2\n"
VERSION_BYTES = 32
REQUEST = struct.Struct("<cII4i")
REPLY = struct.Struct("<?5d")


def serve(requests, replies):
    """Answer every request of one binary stream on another."""
    import cv2
    import numpy as np

    cv2.setNumThreads(1)
    new_tracker = cv2.TrackerCSRT_create  # type: ignore[attr-defined]
    tracker = new_tracker()
    replies.write(HELLO + cv2.__version__.encode().ljust(VERSION_BYTES))
    replies.flush()
    began_s = time.process_time()
    while len(head := requests.read(REQUEST.size)) == REQUEST.size:
        kind, width, height, *box = REQUEST.unpack(head)
        rgb = np.frombuffer(requests.read(width * height * 3), np.uint8).reshape(height, width, 3)
        bgr = np.ascontiguousarray(rgb[..., ::-1])
        found = True
        if kind == b"i":
            tracker = new_tracker()
            tracker.init(bgr, tuple(box))
        else:
            found, box = tracker.update(bgr)
        ended_s = time.process_time()
        replies.write(REPLY.pack(bool(found), *(float(value) for value in box), ended_s - began_s))
        replies.flush()
        began_s = ended_s


if __name__ == "__main__":
    serve(sys.stdin.buffer, sys.stdout.buffer)
