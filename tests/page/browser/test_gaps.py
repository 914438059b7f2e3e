"""A gap in the samples of a scope in a browser: counted in pixels, nothing is drawn there, and it is said."""

import os
import re
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, Page, expect
from running_rig import until

pytestmark = pytest.mark.real

SOURCE = Path(__file__).parents[2] / "support/pulse_source.py"
RIG = """
name: pulses
time: real
devices:
  source: {kind: "pulse_source:PulseSource"}
"""
STOOD_S = 1.5
"""Time for which the process of the device stands; 0.25 s would be bridged."""
HOLE = """() => import('/static/scope/canvas.js').then(({ colour }) => {
  const canvas = document.querySelector('.scope-plot canvas');
  const probe = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  probe.fillStyle = colour(0, false);
  probe.fillRect(0, 0, 1, 1);
  const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
  const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  const columns = new Set();
  for (let at = 0; at < data.length; at += 4)
    if (Math.abs(data[at] - r) + Math.abs(data[at + 1] - g) + Math.abs(data[at + 2] - b) < 24 && data[at + 3] > 60)
      columns.add((at / 4) % canvas.width);
  const there = [...columns].filter((column) => column > 60).sort((one, other) => one - other);  // beside the axis
  return Math.max(0, ...there.slice(1).map((column, place) => column - there[place])) / canvas.width;
})"""
"""The longest part of the canvas, between two columns with the trace of the first signal, that has none of it."""


@pytest.fixture(scope="module")
def source() -> Iterator[ServedRig]:
    """A device in a process of its own, in real time."""
    with ServedRig(RIG, SOURCE) as rig:
        yield rig


def until_traced(page: Page) -> None:
    """Wait until there is a window with the signal."""
    expect(page.locator(".scope-values tbody td").first).to_contain_text(re.compile(r"\d"))


def hole(page: Page) -> float:
    return float(page.evaluate(HOLE))


def test_samples_of_a_process_that_stood_still_are_a_gap_that_is_said(browser: Browser, source: ServedRig) -> None:
    with opened(browser, source, path="/scope/source/ramp") as page:
        page.get_by_role("combobox", name="Window", exact=True).select_option("10 s")
        until_traced(page)
        os.kill(source.pid("source"), signal.SIGSTOP)
        try:
            begin_s = source.status()["uptime_s"]
            until(lambda: source.status()["uptime_s"] > begin_s + STOOD_S)
        finally:
            os.kill(source.pid("source"), signal.SIGCONT)
        said = page.locator(".scope-values tbody tr").first.locator(".pill")
        expect(said).to_have_text(re.compile(r"^\d+ lost in [\d.]+ s$|^not sampled (once|\d+ times), [\d.]+ s$"))
        until(lambda: hole(page) > 0.5 * STOOD_S / 10)


def test_there_is_nothing_where_a_process_was_away(browser: Browser, source: ServedRig) -> None:
    with opened(browser, source, path="/scope/source/ramp") as page:
        page.get_by_role("combobox", name="Window", exact=True).select_option("1 s")
        until_traced(page)
        os.kill(source.pid("source"), signal.SIGKILL)
        source.until_back("source")
        until_traced(page)
        page.get_by_role("combobox", name="Window", exact=True).select_option("10 s")
        until(lambda: hole(page) > 0.01)
