"""Teleservice: calls to MAx-4 controllers by modem, PPP and TCP in virtual time, against the limit of the line."""

import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

if __name__ == "__main__":  # for a run of this file alone
    HERE = Path(__file__).parent
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from dialled_rig import MODEM_BPS, Laptop, Page, call, open_rig, run_until
from report import COMPARED, Report, progress

from fieldrig.clock import MS, S
from fieldrig.virtual.rig import Rig

BAUDS = (38_400, 115_200)
SEGMENT, FRAME = 1460, 1460 + 20 + 20 + 8
"""Bytes of data in a full TCP segment, and of its PPP frame with TCP and IP headers."""
DELAY_MS = 10
"""Delay of the telephone network in each direction, its default."""
CALLS = 50
ROUND_TRIPS = 9
STEP_NS = 50_000
PAGE = "/PARAMS.HTM"


def limit(baud: int) -> float:
    """The bytes a second of the slower of serial line and modems."""
    return min(baud / 10, MODEM_BPS / 8)


def fetched(rig: Rig, laptops: list[Laptop]) -> list[Page]:
    """Fetch a page with every laptop at once."""
    pages = [laptop.fetch(PAGE) for laptop in laptops]
    run_until(rig, laptops, lambda: all(page.is_complete for page in pages))
    return pages


def rate(page: Page) -> float:
    """Bytes a second from the first to the last portion."""
    return sum(page.sizes[1:]) / ((page.instants[-1] - page.instants[0]) / S)


def paced_rate(baud: int) -> tuple[int, float]:
    with open_rig(baud=baud) as rig:
        laptop = Laptop(rig)
        call(rig, [laptop])
        (page,) = fetched(rig, [laptop])
    return page.size, rate(page)


def unpaced_cost(is_called: bool) -> tuple[int, float]:
    """Fetch many pages over a line that takes no time.  Returns the bytes, and the seconds of CPU time."""
    with open_rig(baud=115_200, is_paced=False) as rig:
        laptop = Laptop(rig)
        call(rig, [laptop])
        begin_ns, begin_s, size = rig.now_ns, time.process_time(), 0
        while is_called and size < 1_000_000:
            size += sum(page.size for page in fetched(rig, [laptop]))
        if not is_called:
            run_until(rig, [laptop], lambda: rig.now_ns > begin_ns + 5 * S)
        return size, time.process_time() - begin_s


def round_trip_ms(baud: int) -> tuple[float, float]:
    """The time from SYN to SYN and ACK over an idle line, and the least that its bytes and the delay allow."""
    measured, ideal = list[float](), list[float]()
    with open_rig(baud=baud, axes=1) as rig:
        laptop = Laptop(rig)
        call(rig, [laptop])
        for _ in range(ROUND_TRIPS):
            rest(rig, laptop)
            sent, received, begin_ns = laptop.bytes_sent, laptop.bytes_received, rig.now_ns
            connection, opened = laptop.caller.open(80), list[int]()
            connection.on_open = lambda opened=opened: opened.append(rig.now_ns)  # type: ignore[misc]  # mypy #12557
            laptop.caller.advance(rig.now_ns)
            there = laptop.bytes_sent - sent
            run_until(rig, [laptop], lambda opened=opened: bool(opened), STEP_NS)  # type: ignore[misc]
            back = laptop.bytes_received - received
            measured.append((opened[0] - begin_ns) / MS)
            ideal.append((there + back) / limit(baud) * 1000 + 2 * DELAY_MS)
            connection.abort()
    return sorted(measured)[ROUND_TRIPS // 2], sorted(ideal)[ROUND_TRIPS // 2]


def rest(rig: Rig, laptop: Laptop) -> None:
    end_ns = rig.now_ns + S
    run_until(rig, [laptop], lambda: rig.now_ns > end_ns)


def many_calls() -> tuple[float, float, float, float]:
    """Dial with all laptops at once, and fetch a page with each.

    Returns the slowest rate, the MB of a call, and the seconds of CPU time and of simulated time.
    """
    with open_rig(baud=38_400, pairs=CALLS, axes=4) as rig:
        laptops = [Laptop(rig, pair) for pair in range(CALLS)]
        run_until(rig, (), lambda: all(laptop.is_awaited for laptop in laptops))
        idle_mb, begin_s, begin_ns = resident_mb(), time.process_time(), rig.now_ns
        call(rig, laptops)
        pages = fetched(rig, laptops)
        spent_s, simulated_s = time.process_time() - begin_s, (rig.now_ns - begin_ns) / S
        return min(map(rate, pages)), (resident_mb() - idle_mb) / CALLS, spent_s, simulated_s


def idle_mb_of(pairs: int) -> float:
    """The memory of a process whose controllers wait for calls."""
    with open_rig(baud=38_400, pairs=pairs, axes=4) as rig:
        laptops = [Laptop(rig, pair) for pair in range(pairs)]
        run_until(rig, (), lambda: all(laptop.is_awaited for laptop in laptops))
        return resident_mb()


def resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return pages * 4096 / 1e6


def run() -> Report:
    report = Report(
        "Teleservice",
        "This table shows what calls to a MAx-4 carry in virtual time, beside the slower of line and modems, "
        "and what they cost.",
        COMPARED,
    )
    for baud in BAUDS:
        progress(f"teleservice: {baud} baud")
        size, measured = paced_rate(baud)
        bottleneck = limit(baud) * SEGMENT / FRAME
        report.add(
            f"page of {size / 1000:.0f} kB, {baud} baud, modems of {MODEM_BPS} bit/s",
            f"{measured:,.0f} byte/s",
            f"the line's limit {bottleneck:,.0f} byte/s",
            measured / bottleneck,
        )
    for baud in BAUDS:
        measured, ideal = round_trip_ms(baud)
        what = f"round trip of a TCP handshake, {baud} baud"
        report.add(what, f"{measured:.1f} ms", f"its bytes and delay {ideal:.1f} ms", measured / ideal)
    progress("teleservice: unpaced")
    size, spent_s = unpaced_cost(True)
    _, idle_s = unpaced_cost(False)
    speed, needed = size / spent_s, limit(115_200)
    report.add(
        "pages without pacing, a second of CPU", f"{speed:,.0f} byte/s", f"the line's {needed:,.0f}", speed / needed
    )
    report.notes.append(f"A controller that is called and does nothing takes {idle_s / 5:.3f} s of CPU a second.")
    progress(f"teleservice: {CALLS} calls at once")
    with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
        slowest, call_mb, spent_s, simulated_s = fresh.submit(many_calls).result()
    bottleneck = limit(38_400) * SEGMENT / FRAME
    what = f"slowest of {CALLS} calls at once, 38400 baud"
    report.add(what, f"{slowest:,.0f} byte/s", f"the line's limit {bottleneck:,.0f} byte/s", slowest / bottleneck)
    what = f"{CALLS} calls with a page each, in one process"
    report.add(what, f"{spent_s:.1f} s of CPU", f"{simulated_s:.1f} s of simulated time", spent_s / simulated_s)
    with ProcessPoolExecutor(1, get_context("spawn"), max_tasks_per_child=1) as fresh:
        one_mb, all_mb = fresh.submit(idle_mb_of, 1).result(), fresh.submit(idle_mb_of, CALLS).result()
    pair_mb = (all_mb - one_mb) / (CALLS - 1)
    report.add(
        "memory of a call", f"{call_mb:.2f} MB", f"a controller and two modems {pair_mb:.2f} MB", call_mb / pair_mb
    )
    return report


if __name__ == "__main__":
    print(run().markdown())
