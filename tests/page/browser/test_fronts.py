"""Fronts in a browser, by what a person does: press keys of a terminal, set terminals of a card, hold a key and go."""

import json
import os
import re
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from browser_page import ServedRig, opened
from every_kind import DEVICES, whole
from playwright.sync_api import Browser, Page, expect
from running_rig import until

pytestmark = pytest.mark.real

ECHO = """
BEG ECHO
  MSG 1, "F1 IS DOWN"
  MSG 2, "F1 IS UP"
DARK:
  RES O101
  RES F219
  TERM 1, 1, 2, 2
UP:
  IF F245 = LO, UP
  SET O101
  SET F219
  TERM 1, 1, 2, 1
DOWN:
  IF F245 = HI, DOWN
  GOTO DARK
END
"""
"""The card answers to F1 of its terminal: by an output, the LED of F12, and a text."""
TOO_WIDE = """
Array.from(document.querySelectorAll(".group"), group => [group.ariaLabel, group.scrollWidth - group.clientWidth])
  .filter(([, more]) => more > 0)
"""
"""The groups of a front that are narrower than what is in them."""
RIG: dict[str, Any] = {
    "time": "virtual", "speed": 1,
    "buses": {"can": {"kind": "can.virtual", "bitrate": 500_000}, "wires": {"kind": "wires.virtual"}},
    "devices": {
        "card": {
            "kind": "arp", "number": 1, "program": "echo.I01", "terminal": True, "parameters": {"general": {8: 20}},
            "links": {"can": "can", "wires": "wires"},
        },
        "panel": {"kind": "terminal.tr", "model": "TR4", "node_id": 20, "links": {"can": "can"}},
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def echo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    folder = tmp_path_factory.mktemp("echo")
    (folder / "echo.I01").write_text(ECHO)
    file = folder / "echo.yaml"
    file.write_text(json.dumps(RIG))
    with ServedRig(file) as rig:
        yield rig


@pytest.fixture(scope="module")
def kinds(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    """A rig of every kind, paused."""
    folder = tmp_path_factory.mktemp("kinds")
    file = folder / "kinds.yaml"
    file.write_text(json.dumps({**whole(folder), "speed": 1}))
    with ServedRig(file) as rig:
        yield rig


@pytest.fixture
def enabled(browser: Browser, echo: ServedRig) -> None:
    """The card runs: a person has closed Enable on its front."""
    with opened(browser, echo, path="/device/card") as page:
        enable = page.get_by_role("button", name="I108")
        expect(enable).to_have_attribute("aria-pressed", re.compile("true|false"))  # its value has come
        if enable.get_attribute("aria-pressed") == "false":
            enable.click()
        expect(page.get_by_role("img", name="RUN: lit")).to_be_visible()


def screen(page: Page) -> Any:
    return page.get_by_role("img", name="screen")


@pytest.mark.usefixtures("enabled")
def test_a_key_of_the_terminal_is_held_and_the_card_answers(browser: Browser, echo: ServedRig) -> None:
    with opened(browser, echo, path="/device/panel") as page:
        key = page.get_by_role("button", name="F1", exact=True)
        expect(screen(page)).to_have_accessible_name("screen: F1 IS UP")
        key.hover()
        page.mouse.down()
        expect(screen(page)).to_have_accessible_name("screen: F1 IS DOWN")
        expect(page.get_by_role("img", name="F12: lit")).to_be_visible()
        expect(key).to_have_attribute("aria-pressed", "true")
        page.mouse.up()
        expect(page.get_by_role("img", name="F12: dark")).to_be_visible()


@pytest.mark.usefixtures("enabled")
def test_a_key_is_held_by_the_keyboard(browser: Browser, echo: ServedRig) -> None:
    with opened(browser, echo, path="/device/panel") as page:
        page.get_by_role("button", name="F1", exact=True).focus()
        page.keyboard.down("Space")
        expect(page.get_by_role("img", name="F12: lit")).to_be_visible()
        page.keyboard.up("Space")
        expect(page.get_by_role("img", name="F12: dark")).to_be_visible()


@pytest.mark.usefixtures("enabled")
def test_a_held_key_goes_up_when_the_pointer_leaves_it(browser: Browser, echo: ServedRig) -> None:
    with opened(browser, echo, path="/device/panel") as page:
        page.get_by_role("button", name="F1", exact=True).hover()
        page.mouse.down()
        expect(page.get_by_role("img", name="F12: lit")).to_be_visible()
        page.get_by_role("button", name="F5").hover()
        expect(page.get_by_role("img", name="F12: dark")).to_be_visible()


@pytest.mark.usefixtures("enabled")
def test_a_held_key_goes_up_when_its_page_is_gone(browser: Browser, echo: ServedRig) -> None:
    with opened(browser, echo, "look", path="/device/panel") as beside:
        with opened(browser, echo, path="/device/panel") as page:
            page.get_by_role("button", name="F1", exact=True).hover()
            page.mouse.down()
            expect(beside.get_by_role("img", name="F12: lit")).to_be_visible()
        expect(beside.get_by_role("img", name="F12: dark")).to_be_visible()
        expect(beside.get_by_role("button", name="F1", exact=True)).to_be_disabled()


@pytest.mark.usefixtures("enabled")
def test_a_held_key_goes_up_when_the_server_of_the_page_is_killed(browser: Browser, echo: ServedRig) -> None:
    with opened(browser, echo, path="/device/panel") as page:
        page.get_by_role("button", name="F1", exact=True).hover()
        page.mouse.down()
        expect(page.get_by_role("img", name="F12: lit")).to_be_visible()
        os.kill(echo.status()["ui"]["pid"], signal.SIGKILL)
        expect(page.get_by_role("img", name="F12: dark")).to_be_visible(timeout=60_000)
        assert echo.value("panel/key.F1") is False


def test_a_refusal_is_shown_with_its_reason(browser: Browser, kinds: ServedRig) -> None:
    with opened(browser, kinds, path="/device/tank") as page:
        field = page.get_by_role("textbox", name="level")
        field.fill("5")
        field.press("Enter")
        expect(page.get_by_role("alert")).to_contain_text("expected a number from 0 to 2 m, got 5")


TANK = """
name: tank
time: real
buses: {wires: {kind: wires.hub}}
devices:
  tank:
    kind: plant.tank
    links: {wires: wires}
    area_m2: 0.25
    height_m: 2.0
    outlet_area_m2: 0.0002
    pump_flow_m3_per_s: 0.001
"""


def test_what_is_typed_outlives_a_while_without_answers(browser: Browser) -> None:
    with ServedRig(TANK) as rig, opened(browser, rig, path="/device/tank") as page:
        field, why = page.get_by_role("textbox", name="level"), page.locator("#device .pill")
        field.fill("5")
        os.kill(rig.pid("tank"), signal.SIGSTOP)
        try:
            expect(why).to_be_visible()
            expect(field).to_be_enabled()
        finally:
            os.kill(rig.pid("tank"), signal.SIGCONT)
        expect(why).to_have_count(0)
        expect(field).to_have_value("5")
        field.press("Enter")
        expect(page.get_by_role("alert")).to_contain_text("expected a number from 0 to 2 m, got 5")


def test_the_message_logger_of_a_controller_is_below_its_front(browser: Browser, kinds: ServedRig) -> None:
    with opened(browser, kinds, path="/device/max4") as page:
        expect(page.get_by_role("region", name="Messages: log")).to_contain_text("boot started")


LOGGER = """
from fieldrig import Device, Point


class Logger(Device):
    log_keys = ("log",)

    def __init__(self) -> None:
        self.lines = [f"message {number}" for number in range(60)]

    def points(self) -> dict[str, Point]:
        return {
            "log": Point(lambda: "\\n".join(self.lines)),
            "more": Point(lambda: "", lambda text: self.lines.append(str(text))),
        }
"""
IN_SIGHT = "box => box.scrollTop + box.clientHeight >= box.scrollHeight - 1"


def test_the_newest_message_is_in_sight_unless_a_user_reads_an_older_one(browser: Browser, tmp_path: Path) -> None:
    kinds = tmp_path / "logger.py"
    kinds.write_text(LOGGER)
    rig_text = json.dumps({"time": "virtual", "speed": 1, "devices": {"talker": {"kind": "logger:Logger"}}})
    with ServedRig(rig_text, kinds) as rig, opened(browser, rig, path="/device/talker") as page:
        log = page.locator(".log")
        expect(log).to_contain_text("message 59")
        assert log.evaluate(IN_SIGHT)
        rig.ask("device/talker/set", {"values": {"more": "the next one"}})
        expect(log).to_contain_text("the next one")
        assert log.evaluate(IN_SIGHT)
        log.hover()
        page.mouse.wheel(0, -300)
        until(lambda: not log.evaluate(IN_SIGHT))
        rig.ask("device/talker/set", {"values": {"more": "one more"}})
        expect(log).to_contain_text("one more")
        assert not log.evaluate(IN_SIGHT)


def test_the_front_of_every_kind_is_drawn_without_a_mistake_and_fits(browser: Browser, kinds: ServedRig) -> None:
    with opened(browser, kinds, path="/device/motor") as page:
        for name, device in DEVICES.items():
            page.evaluate("name => { location.hash = `#/device/${name}`; }", name)
            expect(page.locator(".plate code")).to_have_text(device["kind"])
            for width in (390, 1280):
                page.set_viewport_size({"width": width, "height": 860})
                assert page.evaluate("document.documentElement.scrollWidth") <= width, name
                assert page.evaluate(TOO_WIDE) == [], name


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_on_fronts(browser: Browser, kinds: ServedRig, scheme: Any) -> None:
    with opened(browser, kinds, path="/device/motor", scheme=scheme) as page:
        for name in (
            "motor",
            "card",
            "terminal",
            "io",
            "drive",
            "belt",
            "scu",
            "pam",
            "smart",
            "max4",
            "modem",
            "tank",
        ):
            page.evaluate("name => { location.hash = `#/device/${name}`; }", name)
            expect(page.locator("#device")).to_contain_text(name)
            page.locator(".front").wait_for()
            found = Axe().run(page)
            assert found.violations_count == 0, f"{name}: {found.generate_report()}"
