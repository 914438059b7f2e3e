"""The scope of the page: 200 signals recorded at 1 kHz, 16 of them drawn at 30 frames a second in Chromium.

CPU is that of the process itself, from /proc.  The frames are those that the page has drawn, counted by its canvas.
"""

import json
import os
import tempfile
import time
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

from browser_page import ServedRig, chromium, opened
from playwright.sync_api import Page
from report import Report, progress

from fieldrig.system.this_process import own_bytes

ROOT = Path(__file__).parents[2]
SIGNALS, DRAWN = 200, 16
LONG_S, WARM_S = 20.0, 12.0
RIG = """
name: pulses
time: real
devices:
  source: {kind: "pulse_source:PulseSource", period_ms: 2000, sines: 200}
"""
COUNTED = """() => {
  window.drawn = []; window.bytes = 0;
  const clear = CanvasRenderingContext2D.prototype.clearRect;
  CanvasRenderingContext2D.prototype.clearRect = function (...given) {
    window.drawn.push(performance.now());
    return clear.apply(this, given);
  };
}"""
"""Counts the pictures that the scope draws: each begins with an empty canvas."""
LOST = """() => import('/static/live.js').then(({ live }) => new Promise(done => {
  live.on('scope', frame => { if (frame.status) done(Math.max(...frame.status.lost)); });
}))"""


def cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(pid: int) -> float:
    """The memory of a process, without what it shares with others."""
    return (own_bytes(pid) or 0) / (1 << 20)


def children(pid: int) -> list[int]:
    """A process and all of its descendants."""
    found = [pid]
    with suppress(FileNotFoundError, ProcessLookupError):  # a thread or a process may end meanwhile
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                found += children(int(child))
    return found


def server_of(rig: ServedRig) -> int:
    """The process of the page."""
    return next(
        pid
        for pid in children(rig.process.pid)
        if Path(f"/proc/{pid}/comm").read_text(encoding="utf-8").strip() == "rig:ui"
    )


def chromium_of(pid: int) -> int:
    """The first process of Chromium among the descendants of a process."""
    return next(child for child in children(pid) if "chrom" in Path(f"/proc/{child}/comm").read_text(encoding="utf-8"))


def show(page: Page, setup: dict[str, Any]) -> None:
    look: dict[str, Any] = {"isStopped": False, "capture": None, "view": None, "cursors": [], "arm": 0}
    usual = {"recorded": [], "rhythm": 1_000_000, "before": 0.5, "mode": "run", "trigger": None, "xy": None}
    text = json.dumps({"setup": {**usual, **setup}, "look": look})
    page.evaluate("text => sessionStorage.setItem('scope:pulses', text)", text)
    page.reload()


def measured(rig: ServedRig, page: Page, chromium_pid: int) -> tuple[list[str], dict[str, float]]:
    """Measure for a while: CPU in percent, frames, memory and lost samples."""
    server, source = server_of(rig), rig.pid("source")
    browser = children(chromium_pid)
    page.evaluate(COUNTED)
    before = {pid: cpu_s(pid) for pid in (server, source, *browser)}
    memory = memory_mb(server)
    start_s = time.monotonic()
    time.sleep(LONG_S)
    took_s = time.monotonic() - start_s
    drawn = page.evaluate("window.drawn")
    steps = sorted(after - first for first, after in pairwise(drawn))
    lost = page.evaluate(LOST)
    used = {pid: (cpu_s(pid) - before[pid]) / took_s * 100 for pid in before}
    figures = {
        "server": used[server],
        "source": used[source],
        "chromium": sum(used[pid] for pid in browser),
        "frames": len(drawn) / took_s,
        "worst_ms": steps[-1] if steps else 0.0,
        "lost": float(lost),
        "memory": memory_mb(server),
        "growth": memory_mb(server) - memory,
    }
    return drawn, figures


def run() -> Report:
    report = Report(
        "Scope of the page",
        f"{SIGNALS} signals of one device sampled at 1 kHz, {DRAWN} of them drawn in Chromium without a GPU. CPU is in"
        " percent of a core; the first row is the same without a page. Samples lost are those of one signal, with those"
        " that the device's process was too late for.",
        (
            "window",
            "device's process",
            "page's server",
            "Chromium",
            "frames/s",
            "longest pause",
            "samples lost",
            "server's memory",
        ),
    )
    names = [f"source/s{place:03}" for place in range(SIGNALS)]
    with tempfile.TemporaryDirectory(prefix="fieldrig-") as folder:
        file = Path(folder) / "rig.yaml"
        file.write_text(RIG)
        (Path(folder) / "pulse_source.py").symlink_to(ROOT / "tests/support/pulse_source.py")
        with ServedRig(file) as rig:
            server, source = server_of(rig), rig.pid("source")
            before, start_s = (cpu_s(server), cpu_s(source)), time.monotonic()
            time.sleep(LONG_S / 2)
            took_s = time.monotonic() - start_s
            report.add(
                "no page",
                f"{(cpu_s(source) - before[1]) / took_s * 100:.1f} %",
                f"{(cpu_s(server) - before[0]) / took_s * 100:.1f} %",
                *("", "", "", ""),
                f"{memory_mb(server):.0f} MB",
            )
            with chromium() as browser, opened(browser, rig, path="/scope") as page:
                pid = chromium_of(os.getpid())
                for window_s in (10, 1):
                    progress(f"window of {window_s} s")
                    setup = {"signals": names[:DRAWN], "recorded": names[DRAWN:], "window_ns": window_s * 10**9}
                    show(page, setup)
                    time.sleep(WARM_S)
                    _, found = measured(rig, page, pid)
                    report.add(
                        f"{window_s} s",
                        *(f"{found[key]:.1f} %" for key in ("source", "server", "chromium")),
                        f"{found['frames']:.1f}",
                        f"{found['worst_ms']:.0f} ms",
                        f"{found['lost']:.0f}",
                        f"{found['memory']:.0f} MB",
                    )
    return report


if __name__ == "__main__":
    print(run().markdown())
