"""The page of a rig: how soon it is ready in Chromium, and the memory of server and page over a day of virtual time."""

import os
import time
from pathlib import Path

from browser_page import ServedRig, chromium, opened
from page_scope import children, chromium_of, cpu_s, memory_mb, server_of
from playwright.sync_api import Browser
from report import Report, percentile, progress

from fieldrig.clock import S

CONFIGS = Path(__file__).parents[2] / "configs"
TIMES = 5
DAY_H = 24
LOOK_S = 1.0


def ready_ms(browser: Browser, rig: ServedRig) -> tuple[float, float, int]:
    """Return the time from the navigation to the first card of a device, that of the processors, and the requests."""
    context = browser.new_context(viewport={"width": 1280, "height": 860})
    page = context.new_page()
    before_s = used_s(rig)
    page.goto(rig.addresses()["look"], wait_until="commit")
    page.wait_for_selector("main article")
    took_ms, requests = page.evaluate("[performance.now(), performance.getEntriesByType('resource').length]")
    cpu_ms = 1e3 * (used_s(rig) - before_s)
    context.close()
    return took_ms, cpu_ms, requests


def used_s(rig: ServedRig) -> float:
    """The processor time of the page's server and of Chromium so far."""
    return sum(cpu_s(pid) for pid in (server_of(rig), *children(chromium_of(os.getpid()))))


def add_rig(report: Report, browser: Browser, name: str) -> None:
    progress(f"page of {name}")
    with ServedRig(CONFIGS / f"{name}.yaml") as rig:
        found = [ready_ms(browser, rig) for _ in range(TIMES)]
        took_ms, cpu_ms, requests = zip(*found, strict=True)
        memory = f"{memory_mb(server_of(rig)):.0f} MB"
        report.add(
            name,
            f"{percentile(took_ms, 50):.0f} ms",
            f"{max(took_ms):.0f} ms",
            f"{percentile(cpu_ms, 50):.0f} ms",
            str(requests[0]),
            memory,
        )


def add_day(report: Report, browser: Browser) -> None:
    """Let the lab run for a day at full speed with its times open in a browser."""
    progress("a day of the lab")
    with (
        ServedRig(CONFIGS / "lab.yaml", None, "--set=time=virtual", "--set=speed=max") as rig,
        opened(browser, rig, "look", path="/time"),
    ):
        server, chromium_pid = server_of(rig), chromium_of(os.getpid())
        rig.ask("rig/pause")
        found: list[tuple[float, float]] = []
        for _ in range(DAY_H):
            rig.ask("rig/step", {"ns": 3600 * S})
            time.sleep(LOOK_S)
            found.append((memory_mb(server), sum(memory_mb(pid) for pid in children(chromium_pid))))
        first, last = found[0], found[-1]
        report.notes.append(
            f"Memory after 1 and {DAY_H} hours of virtual time, with a page open: {first[0]:.1f} and {last[0]:.1f} MB"
            f" of the server, {first[1]:.0f} and {last[1]:.0f} MB of all processes of Chromium."
        )


def run() -> Report:
    report = Report(
        "Page of a rig",
        "From the navigation to the first card of a device, in Chromium without a GPU, and the memory of the page's"
        " process that it shares with no other.",
        ("rig", "ready", "the slowest of five", "processor time of server and Chromium", "requests", "server's memory"),
    )
    with chromium() as browser:
        for name in ("lab", "machine"):
            add_rig(report, browser, name)
        add_day(report, browser)
    return report


if __name__ == "__main__":
    print(run().markdown())
