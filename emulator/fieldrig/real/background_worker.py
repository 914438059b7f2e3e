"""The process that does one piece of a device's work: `python -m fieldrig.real.background_worker`.

It reads the work from its standard input, and writes frames to its standard output: reports, then the large parts of
the result, then the result itself, or the text of a failure.  What the work prints goes to the log of the device.  It
ends when its standard input ends, because the process of the device is gone or does not want the result any more.
Work that needs too much memory is a failure.
"""

import gc
import os
import pickle
import struct
import sys
import threading
import time
import traceback
from typing import BinaryIO, Final

from fieldrig.loop.background import PROTOCOL, Coarse

HEAD: Final = struct.Struct("<BQ")
"""Head of a frame in either direction: its kind, and the number of bytes that follow."""
WORK, REPORT, PART, RESULT, FAILURE = range(5)
NICENESS: Final = 10
"""How much the process stands back behind the devices of this host."""
MOST_BYTES: Final = 3 << 30
"""Most bytes of address space, where the system can limit it, so that no work takes the memory of the host."""
_PAUSE_S: Final = 0.1  # between two reports


class Answers:
    """The way back to the device."""

    def __init__(self, out: BinaryIO) -> None:
        self._out = out
        self._next_s = 0.0

    def write(self, kind: int, data: bytes | memoryview) -> None:
        self._out.write(HEAD.pack(kind, len(data)))
        self._out.write(data)
        self._out.flush()

    def report(self, what: str, done: int, steps: int) -> None:
        now_s = time.monotonic()
        if now_s >= self._next_s or done >= steps:
            self._next_s = now_s + _PAUSE_S
            self.write(REPORT, pickle.dumps((what, done, steps)))

    def result(self, result: object) -> None:
        parts: list[pickle.PickleBuffer] = []
        data = pickle.dumps(result, PROTOCOL, buffer_callback=parts.append)
        for part in parts:
            self.write(PART, part.raw())
        self.write(RESULT, data)


def main() -> None:
    gc.disable()  # the process ends with its work, and large trees are slow to look through
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    _limit_memory(MOST_BYTES)
    requests, answers = os.fdopen(os.dup(0), "rb", buffering=0), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    _, size = HEAD.unpack(_read(requests, HEAD.size))
    path, work = pickle.loads(_read(requests, size))
    threading.Thread(target=_end_with, args=(requests,), name="parent", daemon=True).start()
    _work(Answers(answers), path, work)


def _limit_memory(most: int) -> None:
    if sys.platform == "linux":
        import resource

        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        soft = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _work(answers: Answers, path: list[str], work: bytes) -> None:
    try:
        sys.path[:] = path
        function, argument = pickle.loads(work)
        answers.result(function(argument, Coarse(answers.report)))
    except MemoryError:
        answers.write(FAILURE, f"it needs more memory than the {MOST_BYTES >> 20} MB of a worker process".encode())
    except Exception as fault:  # noqa: BLE001  the device gets it
        traceback.print_exc()
        answers.write(FAILURE, f"{type(fault).__name__}: {fault}".encode())


def _read(stream: BinaryIO, size: int) -> bytes:
    data = bytearray()
    while len(data) < size:
        part = stream.read(size - len(data))
        if not part:
            os._exit(1)
        data += part
    return bytes(data)


def _end_with(requests: BinaryIO) -> None:
    """End this process when its parent has closed the requests."""
    while requests.read(1):
        pass
    os._exit(1)


if __name__ == "__main__":
    main()
