"""The scope in a browser: what is drawn is counted in pixels, and what a person does is done."""

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, Locator, Page, expect
from running_rig import until

from fieldrig.clock import MS, S

pytestmark = pytest.mark.real

RIG = """
name: pulses
time: virtual
{speed}
devices:
  source: {{kind: "pulse_source:PulseSource", period_ms: {period_ms}, sines: 3}}
"""
SOURCE = Path(__file__).parents[2] / "support/pulse_source.py"
PULSE = {"kind": "edge", "signal": "source/pulse", "level": 0.5, "what": "rising"}
USUAL = {"recorded": [], "rhythm": "cycle", "before": 0.5, "mode": "run", "trigger": None, "xy": None}

COUNT = """([row, isDark]) => {
  const canvas = document.querySelector('.scope-plot canvas');
  if (canvas === null || canvas.width === 0) return 0;
  const probe = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  return import('/static/scope/canvas.js').then(({ colour }) => {
    probe.fillStyle = colour(row, isDark);
    probe.fillRect(0, 0, 1, 1);
    const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
    const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    const columns = new Set();
    for (let at = 0; at < data.length; at += 4) {
      if (Math.abs(data[at] - r) + Math.abs(data[at + 1] - g) + Math.abs(data[at + 2] - b) < 24 && data[at + 3] > 60)
        columns.add((at / 4) % canvas.width);
    }
    return columns.size;
  });
}"""
"""Columns of the canvas that have a pixel in the colour of a row."""


def rig_file(folder: Path, speed: str, period_ms: int) -> Path:
    (folder / SOURCE.name).symlink_to(SOURCE)
    file = folder / "rig.yaml"
    file.write_text(RIG.format(speed=speed, period_ms=period_ms))
    return file


@pytest.fixture(scope="module")
def pulses(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    """A source with a pulse in every 2 s, at the speed of real time."""
    with ServedRig(rig_file(tmp_path_factory.mktemp("pulses"), "speed: 1", 2000)) as rig:
        yield rig


def remember(page: Page, setup: dict[str, Any]) -> None:
    """Give the page a set-up, as an earlier visit of this tab would have left it."""
    look: dict[str, Any] = {"isStopped": False, "capture": None, "view": None, "cursors": [], "arm": 0}
    text = json.dumps({"setup": {**USUAL, **setup}, "look": look})
    page.evaluate("text => sessionStorage.setItem('scope:pulses', text)", text)
    page.reload()


def chosen(page: Page, name: str) -> Locator:
    return page.get_by_role("combobox", name=name, exact=True)


def columns(page: Page, row: int, *, is_dark: bool = False) -> int:
    return int(page.evaluate(COUNT, [row, is_dark]))


def until_drawn(page: Page, row: int, least: int) -> None:
    until(lambda: columns(page, row) >= least)


def test_signals_are_found_by_search_and_drawn(browser: Browser, pulses: ServedRig) -> None:
    with opened(browser, pulses, path="/scope") as page:
        page.get_by_label("Search signals").fill("source s00")
        page.get_by_label("source/s000").check()
        page.get_by_label("Search signals").fill("ramp")
        page.get_by_label("source/ramp").check()
        chosen(page, "Window").select_option("1 s")
        until_drawn(page, 0, 400)
        until_drawn(page, 1, 400)
        expect(page.get_by_role("img", name="2 signals over 1 s, running")).to_be_visible()
        expect(page.locator(".scope-values tbody tr")).to_have_count(2)
        page.get_by_role("button", name="remove source/ramp").click()
        expect(page.locator(".scope-values tbody tr")).to_have_count(1)
        until(lambda: columns(page, 1) == 0)


def until_caught(page: Page) -> None:
    """Wait until the scope stands with what its trigger has caught."""
    expect(page.get_by_role("button", name="Run", exact=True)).to_be_visible()
    expect(page.locator(".scope .pill").first).to_have_text("caught")


def test_a_pulse_of_1_ms_is_caught_with_200_ms_before_it_and_stays_over_a_reload(
    browser: Browser, pulses: ServedRig
) -> None:
    with opened(browser, pulses, path="/scope") as page:
        signals = ["source/pulse", "source/ramp", "source/state"]
        remember(page, {"signals": signals, "window_ns": 400 * MS, "mode": "single", "trigger": PULSE})
        until_caught(page)
        text = page.evaluate("sessionStorage.getItem('scope:pulses')")
        number = json.loads(text)["look"]["capture"]
        until_drawn(page, 1, 700)
        assert columns(page, 0) > 400
        page.get_by_role("button", name="Cursors").click()
        expect(page.locator(".scope-values caption")).to_contain_text("133.333 ms apart (7.50 Hz)")
        expect(page.locator(".scope-values tbody tr").first).to_contain_text("falsefalsesame")
        slider = page.get_by_label("Cursor A")
        slider.fill("501")
        expect(page.locator(".scope-values tbody tr").first).to_contain_text("truefalseother")
        expect(page.locator(".scope-values tbody tr").nth(2)).to_contain_text("highwaitingother")
        page.reload()
        until_caught(page)
        until_drawn(page, 1, 700)
        assert json.loads(page.evaluate("sessionStorage.getItem('scope:pulses')"))["look"]["capture"] == number
        assert columns(page, 0) > 400
        for _ in range(4):
            page.get_by_role("button", name="Zoom in").click()
        expect(page.get_by_role("img", name="signals over 25 ms, caught")).to_be_visible()
        with page.expect_download() as csv:
            page.get_by_role("link", name="CSV").click()
        lines = csv.value.path().read_text().splitlines()
        assert [line.split(",")[1] for line in lines[1:]].count("1") == 1, lines[:4]
        with page.expect_download() as png:
            page.get_by_role("button", name="PNG").click()
        assert png.value.path().read_bytes().startswith(b"\x89PNG")


def test_the_trigger_is_chosen_by_hand_and_counts_on(browser: Browser, pulses: ServedRig) -> None:
    with opened(browser, pulses, path="/scope") as page:
        remember(page, {"signals": ["source/pulse", "source/state"], "window_ns": 100 * MS})
        chosen(page, "Trigger").select_option("state of a signal")
        chosen(page, "Signal").select_option("source/state")
        chosen(page, "Enters").select_option("high")
        expect(page.locator(".scope .pill").first).to_contain_text("2 triggers")


def test_a_text_that_was_not_seen_yet_is_typed_and_caught(browser: Browser, tmp_path: Path) -> None:
    with ServedRig(rig_file(tmp_path, "", 60_000)) as rig:
        rig.ask("rig/pause")
        with opened(browser, rig, path="/scope") as page:
            remember(page, {"signals": ["source/word"], "window_ns": 100 * MS})
            chosen(page, "Trigger").select_option("state of a signal")
            enters = page.get_by_label("Enters", exact=True)
            enters.fill("high")
            enters.press("Enter")
            chosen(page, "Mode").select_option("single")
            expect(page.locator(".scope .pill").first).to_have_text("waiting for the trigger")
            rig.ask("rig/step", {"ns": 61 * S})
            until_caught(page)
            page.get_by_role("button", name="Cursors").click()
            page.get_by_label("Cursor A").fill("501")
            expect(page.locator(".scope-values tbody tr").first).to_contain_text("highwaitingother")


def test_a_window_is_typed_and_caught_where_the_signal_enters_it(browser: Browser, pulses: ServedRig) -> None:
    """A sine of 1 m and 1 Hz enters the window above 0.9 m once in a second."""
    with opened(browser, pulses, path="/scope") as page:
        remember(page, {"signals": ["source/level"], "window_ns": 200 * MS})
        chosen(page, "Trigger").select_option("window of a signal")
        for label, text in (("From", "0.9"), ("To", "2")):
            page.get_by_label(label, exact=True).fill(text)
            page.get_by_label(label, exact=True).press("Enter")
        expect(page.locator(".scope .pill").first).to_contain_text("2 triggers")
        chosen(page, "Mode").select_option("single")
        until_caught(page)
        with page.expect_download() as csv:
            page.get_by_role("link", name="CSV").click()
        rows = [line.split(",") for line in csv.value.path().read_text().splitlines()[1:]]
        values = [float(value) for _, value in rows if value]
        entered = next(place for place, value in enumerate(values) if value >= 0.9)
        assert 0.4 < entered / len(values) < 0.6  # half of the picture is before the trigger
        assert max(values[:entered]) < 0.9


def test_an_address_has_its_signals(browser: Browser, pulses: ServedRig) -> None:
    with opened(browser, pulses, path="/scope") as page:
        remember(page, {"signals": ["source/pulse"]})
        expect(page.locator(".scope-values tbody th")).to_have_text(["source/pulse"])
        page.goto(f"{page.url.partition('#')[0]}#/scope/source/ramp,source/s001")
        expect(page.locator(".scope-values tbody th")).to_have_text(["source/ramp", "source/s001"])
        page.reload()
        expect(page.locator(".scope-values tbody th")).to_have_text(["source/ramp", "source/s001"])


def test_a_set_up_is_saved_and_opened_again(browser: Browser, pulses: ServedRig) -> None:
    with opened(browser, pulses, path="/scope") as page:
        remember(page, {"signals": ["source/ramp"], "window_ns": S})
        page.get_by_text("Set-ups").click()
        page.get_by_label("Set-up", exact=True).fill("ramp of 1 s")
        page.get_by_role("button", name="Save").click()
        expect(page.get_by_text("saved as ramp of 1 s")).to_be_visible()
        remember(page, {"signals": ["source/pulse"]})
        page.get_by_text("Set-ups").click()
        page.get_by_label("Set-up", exact=True).fill("ramp of 1 s")
        page.get_by_role("button", name="Open").click()
        expect(page.locator(".scope-values tbody th")).to_contain_text("source/ramp")
    with opened(browser, pulses, "look", path="/scope") as page:
        page.get_by_text("Set-ups").click()
        expect(page.get_by_role("button", name="Save")).to_have_count(0)


def server_of(rig: ServedRig) -> int | None:
    """The process of the page; None while there is none."""
    children = Path(f"/proc/{rig.process.pid}/task/{rig.process.pid}/children").read_text(encoding="utf-8").split()
    return next(
        (int(pid) for pid in children if Path(f"/proc/{pid}/comm").read_text(encoding="utf-8") == "rig:ui\n"), None
    )


def test_the_scope_goes_on_after_its_server_was_killed(browser: Browser, pulses: ServedRig) -> None:
    with opened(browser, pulses, path="/scope") as page:
        remember(page, {"signals": ["source/ramp"], "window_ns": S})
        until_drawn(page, 0, 400)
        killed = server_of(pulses)
        assert killed is not None
        os.kill(killed, signal.SIGKILL)
        until(lambda: server_of(pulses) not in (None, killed))
        expect(page.locator(".scope-plot canvas")).to_be_visible()
        page.evaluate("for (const canvas of document.querySelectorAll('.scope-plot canvas')) canvas.width = 1")
        until_drawn(page, 0, 400)
        expect(page.locator(".scope .pill").first).to_have_text("rolling")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(browser: Browser, pulses: ServedRig, scheme: Any) -> None:
    with opened(browser, pulses, path="/scope", scheme=scheme) as page:
        signals = ["source/pulse", "source/ramp", "source/state"]
        shot = {"window_ns": 400 * MS, "mode": "single", "trigger": PULSE, "xy": signals[:2]}
        remember(page, {"signals": signals, **shot})
        page.get_by_role("button", name="Cursors").click()
        page.get_by_text("Signals", exact=True).click()
        page.get_by_text("Set-ups").click()
        found = Axe().run(page)
        assert found.violations_count == 0, found.generate_report()


def test_a_pulse_is_caught_an_hour_into_a_run_at_full_speed(browser: Browser, tmp_path: Path) -> None:
    with ServedRig(rig_file(tmp_path, "", 60_000)) as rig:
        rig.ask("rig/pause")
        rig.ask("rig/step", {"ns": 3600 * S})
        with opened(browser, rig, path="/scope") as page:
            remember(page, {"signals": ["source/pulse"], "window_ns": 400 * MS, "mode": "single", "trigger": PULSE})
            expect(page.locator(".scope .pill").first).to_have_text("waiting for the trigger")
            rig.ask("rig/run", {"speed": None})
            until_caught(page)
            rig.ask("rig/pause")
            until_drawn(page, 0, 700)
            number = json.loads(page.evaluate("sessionStorage.getItem('scope:pulses')"))["look"]["capture"]
            with page.expect_download() as csv:
                page.get_by_role("link", name="CSV").click()
            head, *lines = csv.value.path().read_text().splitlines()
            assert (head, number) == ("time_s,source/pulse", 1)
            assert [line for line in lines if line.endswith(",1")] == ["0.200000000,1"]


def test_a_set_up_that_is_refused_has_its_reason_and_the_page_goes_on(browser: Browser, pulses: ServedRig) -> None:
    """The server closed each connection again, and the page said that the server was away, also when loaded again."""
    with opened(browser, pulses, path="/scope") as page:
        chosen(page, "Trigger").select_option("message on a bus")
        words = page.get_by_label("With the words")
        words.fill("a " * 17)
        words.press("Enter")
        refusal = page.get_by_role("alert").filter(has_text="scope is refused: words: expected at most 16 words")
        expect(refusal).to_be_visible()
        expect(page.locator("header .pill")).to_have_text("ready")
        page.reload()
        expect(refusal).to_be_visible()
        expect(page.locator("header .pill")).to_have_text("ready")
        words.fill("a b")
        words.press("Enter")
        expect(refusal).not_to_be_visible()
