"""Serves a tracker to Frameout from a process of its own: copy this one file beside yours (Python >= 3.8, NumPy).

``my_tracker.py`` ends with ``serve(MyTracker)``, a class with ``__init__(parameters, rng)``,
``initialise(observation, box_xyxy)`` and ``update(observation)``, which returns an ``Estimate``; of many targets with
``start(background, camera)`` in place of ``initialise``, and a list of ``Track``. Load weights before ``serve``: a
process serves one episode after another, each with a new tracker. It may print. Then:
``frameout bench frame-out --process my_tracker="python my_tracker.py"``. Protocol: ``trackers/clients/connection.py``.
"""

import copy
import dataclasses
import functools
import json
import mmap
import os
import struct
import sys
import traceback
import types

import numpy as np

VERSION, HEAD = 1, struct.Struct("<QQ")


def _record(name, fields, *bases):
    return dataclasses.make_dataclass(name, [(each, object, None) for each in fields.split()], bases=bases)


_POSTERIOR = "particles_px weights covariance_px"
Estimate = _record(
    "Estimate", "position_px box_xyxy heading_rad in_view_probability " + _POSTERIOR + " depth_m centre_line_px mask"
)
Track = _record("Track", "identity estimate kind size_m confidence")
Bridge = _record("Bridge", "position_px covariance_px")


class _Input:
    centre_px = property(lambda self: np.array([0.5 * self.width_px, 0.5 * self.height_px]))  # Of a camera
    end_frame = property(lambda self: self.first_frame + len(self.position_px))  # Of a piece of a track


@functools.lru_cache(maxsize=None)
def _input(name, fields):
    return _record(name, fields, _Input)


def span(shape, strides, itemsize):
    """Return the bytes before the first element of an array, and the bytes of all of it."""
    steps = [(count - 1) * stride for count, stride in zip(shape, strides)]
    return (0, 0) if 0 in shape else (-sum(min(step, 0) for step in steps), sum(map(abs, steps)) + itemsize)


def encode(value, put):
    """Return a value as JSON has it; ``put(array, before, size)`` stores the bytes of an array and returns where."""
    if hasattr(value, "detach"):  # PyTorch
        value = value.detach().cpu().numpy()
    if isinstance(value, (np.ndarray, np.generic)):
        value = np.asarray(value)
        at = put(value, *span(value.shape, value.strides, value.itemsize))
        return {"is": "array", "of": value.dtype.str, "shape": value.shape, "strides": value.strides, "at": at}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {each.name: encode(getattr(value, each.name), put) for each in dataclasses.fields(value)}
        return {"is": type(value).__name__, **fields}
    if isinstance(value, dict):
        return {"is": "dict", **{name: encode(each, put) for name, each in value.items()}}
    if hasattr(value, "__iter__") and not isinstance(value, str):
        return [encode(each, put) for each in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise TypeError(f"expected numbers, arrays, Estimates or Tracks, got {value!r:.60}")


def decode(value, memory, kind=_input):
    """Return what was encoded, lists as tuples, arrays read-only; ``kind(name, fields)``: class of an object."""
    if isinstance(value, list):
        return tuple(decode(each, memory, kind) for each in value)
    if not isinstance(value, dict):
        return value
    name = value.get("is", "dict")
    if name == "array":
        shape, dtype = tuple(value["shape"]), np.dtype(value["of"])
        if dtype.hasobject:  # Of its bytes addresses would be made.
            raise TypeError("expected an array of numbers")
        before, size = span(shape, value["strides"], dtype.itemsize)
        own = np.array(np.frombuffer(memory, np.uint8, size, value["at"])) if size else np.empty(0, np.uint8)
        own.flags.writeable = False
        return np.ndarray(shape, dtype, own, before, tuple(value["strides"]))
    fields = {key: decode(each, memory, kind) for key, each in value.items() if key != "is"}
    return fields if name == "dict" else kind(name, " ".join(fields))(**fields)


def _message(**content):
    arrays = bytearray()

    def put(array, before, size):
        arrays.extend(bytes(size))
        if size:
            np.ndarray(array.shape, array.dtype, arrays, len(arrays) - size + before, array.strides)[...] = array
        return len(arrays) - size

    text = json.dumps(encode(content, put)).encode()
    return HEAD.pack(len(text), len(arrays)) + text + arrays


def _answer(make, objects, call, of, arguments):
    if call == "make":
        values, state = arguments
        rng = np.random.Generator(getattr(np.random, state["bit_generator"])())
        rng.bit_generator.state = state
        objects.clear()
        objects[0] = made = make(getattr(make, "Parameters", types.SimpleNamespace)(**values), rng)
        return [name for name in ("start", "survey", "revised", "gap_method", "decides_at") if hasattr(made, name)]
    if call in ("copy", "keep"):
        objects[max(objects) + 1] = copy.deepcopy(objects[of]) if call == "copy" else getattr(objects[of], *arguments)
        return max(objects)
    found = getattr(objects[of], call)
    return found(*arguments) if callable(found) else found


def serve(make, name=None):
    """Serve trackers until Frameout closes the pipe; ``make(parameters, rng)``, e.g. a class, returns a new one."""
    if "FRAMEOUT_PIPE" not in os.environ:
        sys.exit(f'this is a tracker for Frameout: frameout bench --process NAME="python {sys.argv[0]}"')
    pipe = [int(number) for number in os.environ.pop("FRAMEOUT_PIPE").split(",")]
    list(map(os.set_inheritable, pipe, [False] * 3))
    source, sink, process = os.fdopen(pipe[0], "rb"), os.fdopen(pipe[1], "wb"), os.getpid()
    memory, objects = b"", {}
    reply = _message(frameout=VERSION, name=name or getattr(make, "__name__", ""), pid=process)
    while os.getpid() == process:  # Else a fork of the tracker's came back.
        sink.write(reply)
        sink.flush()
        head = source.read(HEAD.size)
        if len(head) < HEAD.size:
            return
        size, used = HEAD.unpack(head)
        if used > len(memory):
            memory = mmap.mmap(pipe[2], os.fstat(pipe[2]).st_size, access=mmap.ACCESS_READ)
        request = decode(json.loads(source.read(size)), memory)
        number = request["number"]
        for each in request["drop"]:
            del objects[each]
        try:
            answer = _answer(make, objects, request["call"], request["of"], request["with"])
            reply = _message(number=number, answer=answer, elsewhere_cpu_s=getattr(objects[0], "elsewhere_cpu_s", 0.0))
        except Exception as error:
            at = [list(each)[:2] for each in traceback.extract_tb(error.__traceback__) if each[0] != __file__][-1:]
            reply = _message(number=number, error=f"{type(error).__name__}: {error}", at=at)
    os._exit(1)
