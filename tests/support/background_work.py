"""Work for a background process: functions that a worker can import by name."""

import asyncio
import os
import sys
from pathlib import Path

from fieldrig.loop.background import Bulk, Report
from fieldrig.loop.real_clock import RealClock
from fieldrig.real.background_process import BackgroundProcesses


def squares(upto: int, report: Report) -> list[int]:
    found = []
    for number in range(upto):
        report("squaring", number, upto)
        found.append(number * number)
    return found


def wait_for(gate: str, report: Report) -> str:
    """Report once, then wait until something is written to the pipe `gate`."""
    report("waiting", 1, 2)
    return Path(gate).read_text(encoding="utf-8")


def large(size: int, report: Report) -> tuple[str, Bulk]:
    return "large", Bulk(bytes(range(256)) * (size // 256))


def facts(_: None, report: Report) -> tuple[int, int]:
    """Return the niceness and the scheduling policy of the worker."""
    return os.nice(0), os.sched_getscheduler(0)


def fill(size: int, report: Report) -> int:
    return len(bytearray(size))


def talk(words: str, report: Report) -> int:
    print(words)  # noqa: T201
    return len(words)


def wrong(_: None, report: Report) -> None:
    raise LookupError("no such thing")


def unpicklable(_: None, report: Report) -> object:
    return lambda: None


def end(code: int, report: Report) -> None:
    os._exit(code)


async def host(gate: str) -> None:
    """Let a worker wait, print its process id, and go on without end."""
    processes = BackgroundProcesses(RealClock(asyncio.get_running_loop()))
    waiting = asyncio.Event()
    processes.of("card").run(wait_for, gate, print, lambda *_: waiting.set(), virtual_ns=1)
    await waiting.wait()
    print(processes.pid, flush=True)  # noqa: T201
    await asyncio.Event().wait()


def main() -> None:
    asyncio.run(host(sys.argv[1]))
