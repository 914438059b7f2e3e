"""The picture of a rig in a browser: what a person presses, and what the cards answer."""

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import pytest
from axe_playwright_python.sync_playwright import Axe
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, Locator, Page, expect

CONFIGS = Path(__file__).parents[3] / "configs"
VIEWS = {
    "/": "Rig",
    "/device/max4": "max4",
    "/values": "Values",
    "/traffic": "Traffic",
    "/scope": "Scope",
    "/faults": "fault",
    "/programs": "IEC 61131-3",
    "/time": "time",
}
"""The addresses of all views, with a word of their first heading."""

pytestmark = pytest.mark.real


@pytest.fixture(scope="module")
def ring() -> Iterator[ServedRig]:
    """A controller with four drives on a ring, in virtual time at the speed of real time."""
    with ServedRig(CONFIGS / "ring.yaml", None, "--set=time=virtual") as rig:
        yield rig


@pytest.fixture(scope="module")
def lab() -> Iterator[ServedRig]:
    """The lab in virtual time, paused at 0 s."""
    with ServedRig(CONFIGS / "lab.yaml", None, "--set=time=virtual") as rig:
        rig.ask("rig/pause")
        yield rig


def card(page: Page, name: str) -> Locator:
    return page.locator(f"article[data-part={name}]")


def state(page: Page, name: str) -> Locator:
    return card(page, name).locator(".pill")


def test_a_ring_that_is_broken_in_the_picture_opens_and_the_drives_behind_say_so(
    browser: Browser, ring: ServedRig
) -> None:
    with opened(browser, ring) as page:
        expect(state(page, "jaw")).to_have_text("ready")
        page.get_by_role("button", name="break ring between infeed and film").click()
        expect(page.locator(".strip .pill")).to_have_text("open")
        expect(state(page, "film")).to_have_text("trouble")
        expect(state(page, "infeed")).to_have_text("ready")
        expect(page.locator(".events li").first).to_contain_text("the ring is open")
        page.reload()
        page.get_by_role("button", name="heal ring between infeed and film").click()
        expect(page.get_by_role("button", name="break ring between infeed and film")).to_be_visible()
        expect(page.locator(".strip .pill")).to_have_count(0)
        assert {fault["state"] for fault in ring.ask("bus/ring/faults").values()} <= {"over"}


def test_a_device_is_switched_off_and_on_from_its_card(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab) as page:
        card(page, "sensor").get_by_role("button").click()
        about = page.get_by_role("complementary", name="about sensor")
        about.get_by_role("button", name="Power off").click()
        expect(state(page, "sensor")).to_have_text("power off")
        about.get_by_role("button", name="Power on").click()
        expect(state(page, "sensor")).to_have_text("ready")


def test_the_chosen_card_shows_its_wires_and_partners_and_each_part_is_a_link(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab) as page:
        card(page, "io").get_by_role("button").click()
        about = page.get_by_role("complementary", name="about io")
        expect(about.get_by_role("row", name="tank.level")).to_contain_text("0.500 m")
        expect(card(page, "tank")).to_have_class("card ok partner")
        about.get_by_role("button", name="tank").first.click()
        expect(page.get_by_role("complementary", name="about tank")).to_be_visible()
        page.keyboard.press("Escape")
        expect(page.get_by_role("complementary")).to_have_count(0)
        expect(card(page, "tank").get_by_role("button")).to_be_focused()
        expect(card(page, "io").get_by_role("link", name="io", exact=True)).to_have_attribute("href", "#/device/io")
        expect(card(page, "io").get_by_role("link", name="can0")).to_have_attribute("href", "#/bus/can0")


def test_a_small_rig_has_the_scope_beside_its_picture_from_the_start(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab) as page:
        scope = page.get_by_role("region", name="scope")
        for signal in ("tank/level", "sensor/6130:01", "drive/level"):
            expect(scope.get_by_role("row", name=signal)).to_be_visible()
        picture = page.get_by_role("region", name="Rig").bounding_box()
        beside = scope.bounding_box()
        assert picture is not None
        assert beside is not None
        assert picture["x"] + picture["width"] <= beside["x"]


def test_the_line_of_a_card_is_that_of_a_value_that_moves(browser: Browser, lab: ServedRig) -> None:
    lab.ask("device/drive/set", {"values": {"speed_set": 80, "run": True}})
    with opened(browser, lab) as page:
        expect(card(page, "io").get_by_role("img", name="io Read inputs byte 1, its last values")).to_be_visible()
        lab.ask("rig/run")
        expect(card(page, "io").get_by_role("img", name="io Analogue input 1, its last values")).to_be_visible()
        lab.ask("rig/pause")


def test_a_page_for_looking_only_has_nothing_to_press(browser: Browser, ring: ServedRig) -> None:
    with opened(browser, ring, "look") as page:
        expect(page.get_by_role("button", name="break ring between infeed and film")).to_be_disabled()
        card(page, "film").get_by_role("button").click()
        about = page.get_by_role("complementary", name="about film")
        expect(about).to_be_visible()
        expect(about.get_by_role("button", name="Power off")).to_have_count(0)


def test_virtual_time_is_stepped_and_run_until_a_time(browser: Browser, lab: ServedRig) -> None:
    begin_ns = lab.status()["now_ns"]
    with opened(browser, lab, path="/time") as page:
        page.get_by_label("step").select_option("1 s")
        page.get_by_role("button", name="Step").click()
        expect(page.locator(".clock")).to_have_text(f"00:00:{begin_ns / 1e9 + 1:06.3f}")
        page.get_by_label("run until (s)").fill("40")
        page.get_by_role("button", name="Go").click()
        expect(page.locator(".clock")).to_have_text("00:00:40.000")
        page.get_by_role("button", name="Run", exact=True).click()
        expect(page.get_by_role("button", name="Pause")).to_be_visible()
        page.get_by_role("button", name="Pause").click()
        expect(page.get_by_role("button", name="Run", exact=True)).to_be_visible()
    assert lab.status()["now_ns"] >= 40_000_000_000


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_violation(browser: Browser, ring: ServedRig, scheme: Literal["light", "dark"]) -> None:
    with opened(browser, ring, scheme=scheme) as page:
        for view in shown_views(page):
            if view == "/":
                card(page, "film").get_by_role("button").click()
            found = Axe().run(page)  # by the debugging protocol: the policy of the page lets no script of others in
            assert found.violations_count == 0, f"{view}\n{found.generate_report()}"


def test_a_telephone_scrolls_only_downwards_and_shows_two_cards_abreast(browser: Browser, ring: ServedRig) -> None:
    with opened(browser, ring, width=390, height=844) as page:
        for view in shown_views(page):
            assert page.evaluate("document.documentElement.scrollWidth") == 390, view
            if view == "/":
                boxes = [one.bounding_box() for one in page.locator("article").all()]
                assert len({round(box["x"]) for box in boxes if box is not None}) == 2


def shown_views(page: Page) -> Iterator[str]:
    """Show one view after the other, and yield its address when it is there."""
    expect(state(page, "panel")).to_have_text("ready")
    for view in VIEWS:
        page.evaluate(f"location.hash = '#{view}'")
        expect(page.locator("main section h2").first).to_contain_text(VIEWS[view])
        yield view
