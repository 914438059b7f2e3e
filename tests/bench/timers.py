"""How late the real clock's timers are: periods of 1 and 10 ms, idle and loaded, with and without SCHED_FIFO."""

import asyncio
import multiprocessing
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager

import uvloop
from report import Report, percentile, progress

from fieldrig.clock import MS, S
from fieldrig.loop.real_clock import RealClock

SECONDS = 2


async def lateness_of_real_clock_us(period_ns: int) -> list[float]:
    """Lateness of each tick, by the wall, of a timer that asks for its own instant plus a period."""
    clock = RealClock(asyncio.get_running_loop())
    ticks, late_us = SECONDS * S // period_ns, []
    done = asyncio.Event()

    def tick() -> None:
        now_ns = clock.now_ns()
        late_us.append((time.monotonic_ns() - now_ns) / 1e3)
        if len(late_us) == ticks:
            done.set()
        else:
            clock.call_at(now_ns + period_ns, tick)

    clock.call_at(clock.now_ns() + period_ns, tick)
    await done.wait()
    clock.close()
    return late_us


async def lateness_of_loop_us(period_ns: int) -> list[float]:
    """The peer: the same with asyncio's own `loop.call_at`."""
    loop = asyncio.get_running_loop()
    ticks, late_us = SECONDS * S // period_ns, []
    done = asyncio.Event()

    def tick(due_s: float) -> None:
        late_us.append((time.monotonic() - due_s) * 1e6)
        if len(late_us) == ticks:
            done.set()
        else:
            loop.call_at(due_s + period_ns / S, tick, due_s + period_ns / S)

    start_s = loop.time() + period_ns / S
    loop.call_at(start_s, tick, start_s)
    await done.wait()
    return late_us


def _burn() -> None:
    while True:
        pass


@contextmanager
def busy_cores() -> Iterator[None]:
    burners = [multiprocessing.Process(target=_burn, daemon=True) for _ in range(os.cpu_count() or 1)]
    for burner in burners:
        burner.start()
    try:
        yield
    finally:
        for burner in burners:
            burner.kill()
            burner.join()


@contextmanager
def fifo() -> Iterator[None]:
    """SCHED_FIFO for this process.  OSError where the system doesn't permit it."""
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
    try:
        yield
    finally:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def run() -> Report:
    report = Report(
        "Timers of the real clock",
        f"This table compares the lateness of a periodic timer with `call_at` of asyncio: {SECONDS} s each, in us.",
        ("period", "load", "scheduler", "real clock p50", "p99", "asyncio p50", "p99", "ratio of p50"),
    )

    def measure(load: str, scheduler: str) -> None:
        for period_ns in (MS, 10 * MS):
            progress(f"timers: {period_ns // MS} ms, {load}, {scheduler}")
            ours_us = uvloop.run(lateness_of_real_clock_us(period_ns))
            theirs_us = asyncio.run(lateness_of_loop_us(period_ns))
            median_us, their_median_us = percentile(ours_us, 50), percentile(theirs_us, 50)
            report.add(
                f"{period_ns // MS} ms", load, scheduler,
                f"{median_us:.0f}", f"{percentile(ours_us, 99):.0f}",
                f"{their_median_us:.0f}", f"{percentile(theirs_us, 99):.0f}", f"{median_us / their_median_us:.2f}",
            )  # fmt: skip

    measure("idle", "normal")
    with busy_cores():
        measure("all cores busy", "normal")
    try:
        with fifo():
            measure("idle", "FIFO")
        with busy_cores(), fifo():
            measure("all cores busy", "FIFO")
    except OSError as cause:
        report.notes.append(f"SCHED_FIFO is not permitted here: {cause}")
    return report


if __name__ == "__main__":
    print(run().markdown())
