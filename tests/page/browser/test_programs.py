"""Programs in a browser, of each language: what a person sees of them, stops, starts and forces."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, Page, expect
from running_rig import until

from fieldrig.clock import S

CONFIGS = Path(__file__).parents[3] / "configs"
LAMP = """
BEG LAMP
DARK:
  RES O102
UP:
  IF I101 = LO, UP
  SET O102
DOWN:
  IF I101 = HI, DOWN
  GOTO DARK
END
"""
"""The card shows by its output 102 whether its input 101 is on."""
CARD = """
time: virtual
speed: 1
devices: {card: {kind: arp, number: 1, program: lamp.I01}}
"""
APPLICATION = """
APPLICATION NAME = sums V1.00; BASIC_PAM_CYCLE = 3; END
INTERNAL FLAG_VAR IFV_Begin;
INTERNAL WORD_VAR IWV_Step;
INTERNAL WORD_VAR IWV_Total;
TASK TSK_Sum; SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IFV_Begin XEQ_SEQUENCE SEQ_Sum; END_EVENTS
  SEQUENCE SEQ_Sum;
    LOOP
      WAIT_TIME 100;
      IWV_Total <- IWV_Total + IWV_Step;
      IWV_Step <- 1;
    END_LOOP !IFV_Begin;
  END_SEQUENCE
  POWERON IFV_Begin <- set; END_POWERON
END_TASK
"""
PAM = """
time: virtual
speed: 1
buses: {ring: {kind: pamring.virtual}}
devices: {pam: {kind: pam, application: app.pam, links: {ring: ring}}}
"""

pytestmark = pytest.mark.real


@pytest.fixture(scope="module")
def feeder() -> Iterator[ServedRig]:
    with ServedRig(CONFIGS / "feeder.yaml", None, "--set=time=virtual") as rig:
        yield rig


@pytest.fixture(scope="module")
def card(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    """An ARP card whose program runs."""
    folder = tmp_path_factory.mktemp("card")
    (folder / "lamp.I01").write_text(LAMP)
    (folder / "rig.yaml").write_text(CARD)
    with ServedRig(folder / "rig.yaml") as rig:
        rig.ask("device/card/set", {"values": {"I108": True}})  # Enable
        yield rig


@pytest.fixture(scope="module")
def pam(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    """A PAM whose application adds a step to a total ten times a second."""
    folder = tmp_path_factory.mktemp("pam")
    (folder / "app.pam").write_text(APPLICATION)
    (folder / "rig.yaml").write_text(PAM)
    with ServedRig(folder / "rig.yaml") as rig:
        until(lambda: total(rig) > 0)
        yield rig


def total(pam: ServedRig) -> int:
    """Return the total that the application has computed."""
    (variable,) = pam.ask("device/pam/debug", {"command": "read", "names": ["IWV_Total"]})["variables"]
    return int(variable["value"])


def until_later(rig: ServedRig) -> None:
    """Wait until the rig has run for another second."""
    begin_ns = rig.status()["now_ns"]
    until(lambda: rig.status()["now_ns"] > begin_ns + S)


def force(page: Page, name: str, value: str) -> None:
    """Force a variable by the form."""
    page.get_by_label("variable", exact=True).fill(name)
    page.get_by_label("value", exact=True).fill(value)
    page.get_by_role("button", name="Force").click()


def test_a_variable_is_forced_and_released(browser: Browser, feeder: ServedRig) -> None:
    with opened(browser, feeder, path="/programs/feeder") as page:
        expect(page.get_by_role("region", name="source feeder.st")).to_contain_text("g_udiRamp = 200")
        force(page, "g_udiRamp", "77")
        expect(page.get_by_role("button", name="Release g_udiRamp")).to_be_visible()
        expect(page.get_by_role("region", name="source feeder.st")).to_contain_text("g_udiRamp = 77")
        page.get_by_role("button", name="Release g_udiRamp").click()
        expect(page.get_by_role("button", name="Release g_udiRamp")).to_have_count(0)


WIDE = """
PROGRAM Main
VAR
    t : TIME := T#1h; (* the T of the literal is no variable *)
    isOn : BOOL := TRUE;
    r : REAL;
    wide : ULINT := 1;
END_VAR
r := 0.5;
END_PROGRAM
"""


def test_literals_are_no_variables_and_whole_numbers_have_all_their_digits(browser: Browser, tmp_path: Path) -> None:
    """`T = T#1h` stood beside the time, and `TRUE = true` beside the flag; a forced ULINT was rounded."""
    (tmp_path / "wide.st").write_text(WIDE)
    file = tmp_path / "plc.yaml"
    file.write_text("{time: virtual, speed: 1, devices: {plc: {kind: hmiscu, model: HMISCU6A5, program: wide.st}}}")
    with ServedRig(file) as rig, opened(browser, rig, path="/programs/plc") as page:
        source = page.get_by_role("region", name="source wide.st")
        expect(source).to_contain_text("isOn = true")
        expect(source.locator(".live-value").filter(has_text="T#1h")).to_have_text("t = T#1h")
        expect(source.locator(".live-value").filter(has_text=re.compile("^TRUE"))).to_have_count(0)
        force(page, "Main.wide", str(2**64 - 1))
        expect(page.get_by_role("row", name="Main.wide")).to_contain_text(str(2**64 - 1))
        force(page, "Main.r", "1e999")
        expect(page.get_by_role("alert")).to_contain_text("expected a constant of type REAL, got '1e999'")


def test_a_program_opens_where_it_is_with_its_values_in_sight(browser: Browser) -> None:
    """Its first task that runs shows signs of life, in a loop from line 330 on, some of whose lines are long."""
    with (
        ServedRig(CONFIGS / "pam-machine.yaml", None, "--set=time=virtual") as rig,
        opened(browser, rig, path="/programs/pam") as page,
    ):
        expect(page.get_by_role("region", name="source labeller.pam")).to_contain_text("SBO_AliveStack <- ")
        box = page.get_by_role("region", name="source labeller.pam").bounding_box()
        values = page.locator("td.live").filter(has_text="SBO_AliveStack").first.bounding_box()
        assert box is not None
        assert values is not None
        assert box["x"] < values["x"]
        assert values["x"] + values["width"] <= box["x"] + box["width"]


def test_a_program_is_stopped_and_started(browser: Browser, feeder: ServedRig) -> None:
    with opened(browser, feeder, path="/programs/sealer") as page:
        page.get_by_role("button", name="Stop").click()
        expect(page.get_by_role("button", name="Start")).to_be_enabled()
        page.get_by_role("button", name="Start").click()
        expect(page.get_by_role("button", name="Stop")).to_be_enabled()


def test_the_program_of_a_card_sees_a_forced_input(browser: Browser, card: ServedRig) -> None:
    with opened(browser, card, path="/programs/card") as page:
        current = page.get_by_role("region", name="source lamp.I01").locator("tr.current")
        expect(current).to_contain_text("IF I101 = LO, UP")
        force(page, "I101", "true")
        expect(current).to_contain_text("IF I101 = HI, DOWN")
        expect(current).to_contain_text("I101 = 1")
        assert card.value("card/O102") is True
        page.get_by_role("button", name="Release I101").click()
        expect(current).to_contain_text("IF I101 = LO, UP")
        assert card.value("card/O102") is False
        force(page, "V1", "5")
        expect(page.get_by_role("alert")).to_contain_text("V1")


def test_a_card_whose_program_is_stopped_answers_to_no_input(browser: Browser, card: ServedRig) -> None:
    with opened(browser, card, path="/programs/card") as page:
        current = page.get_by_role("region", name="source lamp.I01").locator("tr.current")
        expect(current).to_contain_text("IF I101 = LO, UP")
        page.get_by_role("button", name="Stop").click()
        expect(page.get_by_role("button", name="Start")).to_be_enabled()
        card.ask("device/card/set", {"values": {"I101": True}})
        until_later(card)
        assert card.value("card/O102") is False
        page.get_by_role("button", name="Start").click()
        expect(current).to_contain_text("IF I101 = HI, DOWN")
        assert card.value("card/O102") is True
        card.ask("device/card/set", {"values": {"I101": False}})
        until(lambda: card.value("card/O102") is False)


def test_an_application_of_a_pam_computes_with_the_forced_value(browser: Browser, pam: ServedRig) -> None:
    with opened(browser, pam, path="/programs/pam") as page:
        source = page.get_by_role("region", name="source app.pam")
        expect(source).to_contain_text("IWV_Step = 1")
        force(page, "IWV_Step", "1000")
        expect(page.get_by_role("button", name="Release IWV_Step")).to_be_visible()
        until(lambda: total(pam) > 2000)  # which the application never reaches by steps of 1 within this test
        expect(source).to_contain_text("IWV_Step = 1000")
        page.get_by_role("button", name="Release IWV_Step").click()
        expect(source.get_by_text("IWV_Step = 1", exact=True).first).to_be_visible()
        force(page, "IWV_Step", "a step")
        expect(page.get_by_role("alert")).to_contain_text("IWV_Step")


def test_an_application_of_a_pam_is_stopped_where_it_is_and_started(browser: Browser, pam: ServedRig) -> None:
    with opened(browser, pam, path="/programs/pam") as page:
        page.get_by_role("button", name="Stop").click()
        expect(page.get_by_role("button", name="Start")).to_be_enabled()
        before = total(pam)
        until_later(pam)
        assert total(pam) == before
        page.get_by_role("button", name="Start").click()
        expect(page.get_by_role("button", name="Stop")).to_be_enabled()
        until(lambda: total(pam) > before)
