"""The cost of the page of a rig to a ring of 40 drives: cycles kept and round trip with no page open, one, and five.

Windows alternate in one run, there and back again, so that a busy host treats them alike, and medians are compared.
The browser runs on the same host, so a window with one busy core and no page shows what any other
program costs the ring.
"""

import json
import subprocess
import sys
from collections.abc import Callable
from contextlib import ExitStack
from statistics import median

from browser_page import ServedRig, chromium, opened
from playwright.sync_api import Browser
from report import Report, progress
from ring import CASES, DEVICES, DRIVES, SECONDS, Case, Outcome, measured, rig_of
from running_rig import until

ROUNDS = 4
BUSY = -1
"""Stands for no page, and a core that is busy with something else."""
WINDOWS = (0, 1, 5, BUSY)
RINGS = (CASES[0], CASES[-1])
"""Over Zenoh with a process per drive at 4 ms, and over shared memory with one process at 1 ms."""
FIGURES: tuple[tuple[str, Callable[[Outcome], float], str], ...] = (
    ("cycles kept in %", lambda outcome: outcome.kept_percent, ".2f"),
    ("round trip p50 in us", lambda outcome: outcome.p50_us, ",.0f"),
    ("round trip p99 in us", lambda outcome: outcome.p99_us, ",.0f"),
)


def window(browser: Browser, rig: ServedRig, pages: int) -> Outcome:
    """Measure while this number of pages shows the picture of the rig."""
    with ExitStack() as stack:
        if pages == BUSY:
            busy = stack.enter_context(subprocess.Popen([sys.executable, "-c", "while True: pass"]))
            stack.callback(busy.kill)
        for page in [stack.enter_context(opened(browser, rig, "look")) for _ in range(pages)]:
            page.wait_for_selector("main article")
        return measured(rig)


def add_ring(report: Report, browser: Browser, case: Case) -> None:
    progress(f"page of the ring {case.what}")
    with ServedRig(json.dumps(rig_of(case, is_full=True)), DEVICES) as rig:
        until(lambda: rig.value("max4/moving") == DRIVES)
        found: dict[int, list[Outcome]] = {pages: [] for pages in WINDOWS}
        for number in range(ROUNDS):
            for pages in WINDOWS if number % 2 == 0 else reversed(WINDOWS):
                found[pages].append(window(browser, rig, pages))
    for what, of_it, form in FIGURES:
        of = {pages: [of_it(outcome) for outcome in outcomes] for pages, outcomes in found.items()}
        middle = {pages: median(numbers) for pages, numbers in of.items()}
        spread = {pages: f"{min(numbers):{form}} to {max(numbers):{form}}" for pages, numbers in of.items()}
        cells = [f"{middle[pages]:{form}} ({spread[pages]})" for pages in WINDOWS]
        ratios = [f"{middle[pages] / middle[0]:.3f}" for pages in WINDOWS[1:]]
        report.add(f"{case.what}: {what}", *cells, *ratios)


def run() -> Report:
    report = Report(
        "Page of a ring of 40 drives",
        f"{ROUNDS} windows of {SECONDS:g} s each, in turn, with the picture of the rig in Chromium on the same host,"
        " and with a busy core and no page: medians, and lowest to highest.",
        (
            *("quantity", "no page", "one page", "five pages", "a busy core"),
            *("one to none", "five to none", "busy core to none"),
        ),
    )
    with chromium() as browser:
        for case in RINGS:
            add_ring(report, browser, case)
    return report


if __name__ == "__main__":
    print(run().markdown())
