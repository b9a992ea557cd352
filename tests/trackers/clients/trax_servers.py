"""TraX trackers for tests: ``python trax_servers.py KIND VERSION IMAGE REGION [FAULT]``, KIND ``by-hand`` or
``reference``. They answer with the region that they got, and as confidence with the mean of the picture over 255.
"""

import base64
import shlex
import sys

import cv2
import numpy as np

KIND, VERSION, IMAGE, REGION, *FAULT = sys.argv[1:]


def say(text):
    print(text, flush=True)


def mean_of(image):
    kind, _, rest = image.partition(":")
    if kind == "file":
        pixels = cv2.imread(rest.removeprefix("//"))
    elif kind == "image":
        width, height, rgb, data = rest.split(";")
        assert rgb == "rgb"
        pixels = np.frombuffer(base64.b64decode(data), np.uint8).reshape(int(height), int(width), 3)
    else:
        assert rest.startswith("image/png;")
        png = np.frombuffer(base64.b64decode(rest.removeprefix("image/png;")), np.uint8)
        pixels = cv2.imdecode(png, cv2.IMREAD_COLOR)
    return pixels.mean() / 255.0


def by_hand():
    say("a banner that is no message")
    version = "" if VERSION == "1" else f' "trax.version={VERSION}"'
    channels = ' "trax.channels=color;depth;"' if FAULT == ["depth"] else ""
    if FAULT == ["no-greeting"]:
        say('@@TRAX:state "1,2,3,4"')
    say(f'@@TRAX:hello{version} "trax.name=a \\"name\\"" "trax.image={IMAGE};" "trax.region={REGION};"{channels}')
    region, frames = None, 0
    for line in sys.stdin:
        name, *words = shlex.split(line)
        print("a word on stderr", file=sys.stderr)
        if name == "@@TRAX:quit":
            return
        if name == "@@TRAX:initialize":
            region = words[-1]
            if VERSION == "4":
                assert len(words) == 1
                continue
        frames += 1
        if FAULT == ["quits"] and frames == 2:
            say('@@TRAX:quit "trax.reason=no more memory"')
            return
        if FAULT == ["nonsense"] and frames == 2:
            region = "here"
        say("between")
        state = f'@@TRAX:state "{region}" confidence={mean_of(words[0]):.12f}'
        say(f"{state}\n{state}" if FAULT == ["twice"] else state)


def reference():
    from trax import Image, Region, Server

    image, region = getattr(Image, IMAGE.upper()), getattr(Region, REGION.upper())
    server = Server([region], [image], tracker_name="reference")
    while True:
        request = server.wait()
        if request.type == "quit":
            return
        if request.type == "initialize":
            objects = [each[0] for each in request.objects]
        given = request.image["color"]
        if IMAGE == "path":
            pixels = cv2.imread(given.path())
        elif IMAGE == "memory":
            pixels = given.array()
        else:
            pixels = cv2.imdecode(np.frombuffer(given.buffer(), np.uint8), cv2.IMREAD_COLOR)
        server.status([(each, {"confidence": float(pixels.mean() / 255.0)}) for each in objects])


by_hand() if KIND == "by-hand" else reference()
