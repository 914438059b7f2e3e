"""The page by keyboard alone: what is pressed may vanish or be off then, and the focus is at its neighbour."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, Locator, Page, expect

FEEDER = Path(__file__).parents[3] / "configs" / "feeder.yaml"

pytestmark = pytest.mark.real


@pytest.fixture(scope="module")
def feeder() -> Iterator[ServedRig]:
    with ServedRig(FEEDER, None, "--set=time=virtual", "--set=speed=1") as rig:
        yield rig


def press(page: Page, what: Locator) -> None:
    """Press something by the keyboard."""
    what.focus()
    page.keyboard.press("Enter")


def test_stop_leads_to_start_and_start_to_stop(browser: Browser, feeder: ServedRig) -> None:
    with opened(browser, feeder, path="/programs/sealer") as page:
        press(page, page.get_by_role("button", name="Stop"))
        expect(page.get_by_role("button", name="Start")).to_be_focused()
        page.keyboard.press("Enter")
        expect(page.get_by_role("button", name="Stop")).to_be_focused()


def test_pause_leads_to_run_and_a_step_can_be_made_again(browser: Browser, feeder: ServedRig) -> None:
    with opened(browser, feeder, path="/time") as page:
        press(page, page.get_by_role("button", name="Pause"))
        expect(page.get_by_role("button", name="Run", exact=True)).to_be_focused()
        begin_ns = feeder.status()["now_ns"]
        press(page, page.get_by_role("button", name="Step"))
        page.keyboard.press("Enter")
        expect(page.locator(".clock")).to_contain_text(f"{(begin_ns / 1e9 + 0.02) % 60:.3f}")
        expect(page.get_by_role("button", name="Step")).to_be_focused()
        press(page, page.get_by_role("button", name="Run", exact=True))
        expect(page.get_by_role("button", name="Pause")).to_be_focused()


def test_a_row_that_vanishes_leads_to_the_one_in_its_place(browser: Browser, feeder: ServedRig) -> None:
    names = ("g_udiLength", "g_udiRamp", "g_udiSpeed")
    feeder.ask("device/feeder/debug", {"command": "force", "values": dict.fromkeys(names, 99)})
    with opened(browser, feeder, path="/programs/feeder") as page:
        first, second, third = (page.get_by_role("button", name=f"Release {name}") for name in names)
        press(page, second)
        expect(second).to_have_count(0)
        expect(third).to_be_focused()
        page.keyboard.press("Enter")
        expect(third).to_have_count(0)
        expect(first).to_be_focused()
        page.keyboard.press("Enter")
        expect(page.get_by_role("button", name="Write once")).to_be_focused()


def test_a_key_has_the_focus_again_when_its_device_has_power(browser: Browser, feeder: ServedRig) -> None:
    with opened(browser, feeder, path="/device/feeder") as page:
        key = page.get_by_role("button", name="Run", exact=True)
        page.keyboard.press("Tab")
        key.focus()
        number = feeder.ask("device/feeder/add_fault", {"fault": {"what": "power_off"}})["number"]
        expect(key).to_be_disabled()
        expect(key).not_to_be_focused()
        feeder.ask("device/feeder/clear_fault", {"number": number})
        expect(key).to_be_focused()


def test_a_link_leads_into_the_view_that_it_opens(browser: Browser, feeder: ServedRig) -> None:
    with opened(browser, feeder) as page:
        press(page, page.locator("article").get_by_role("link", name="heater"))
        expect(page.get_by_role("heading", name="heater", exact=True)).to_be_visible()
        expect(page.locator("main")).to_be_focused()


def test_who_uses_a_pointer_keeps_the_keyboard_of_the_telephone_closed(browser: Browser, feeder: ServedRig) -> None:
    """The neighbour of Go would be a field."""
    with opened(browser, feeder, path="/programs/sealer") as page:
        page.get_by_role("button", name="Stop").click()
        expect(page.get_by_role("button", name="Start")).to_be_enabled()
        expect(page.get_by_role("button", name="Start")).not_to_be_focused()
        page.get_by_role("button", name="Start").click()
