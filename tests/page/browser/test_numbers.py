"""Numbers in a browser: they have all their digits, and what a person types stays while samples come."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, Locator, Page, expect
from running_rig import until

pytestmark = pytest.mark.real

LARGE = 2**53 + 1
"""The first whole number that JavaScript has not (ECMA-262, `Number.MAX_SAFE_INTEGER`)."""
FINE = 0.12345678901234568
"""A float with more digits than a list shows."""
TABLE = f"""
holding_registers:
  - {{address: 0, name: date, type: u32, initial: 20260131}}
  - {{address: 2, name: total, type: u64, initial: {LARGE}}}
  - {{address: 6, name: ratio, type: f32, initial: 0.25}}
  - {{address: 8, name: sensor, type: f32}}
  - {{address: 10, name: factor, type: f64, initial: {FINE}}}
input_registers:
  - {{address: 0, name: turns, type: u32, source: {{kind: counter, per_s: 1000, first: 73113480}}}}
"""
RIG = {
    "name": "counters",
    "time": "virtual",
    "speed": 1,
    "buses": {"line": {"kind": "modbus.virtual"}},
    "devices": {"store": {"kind": "modbus.device", "unit_id": 1, "table": "table.yaml", "links": {"modbus": "line"}}},
}

DRIVE = {
    "name": "drive",
    "time": "virtual",
    "speed": 1,
    "buses": {"can": {"kind": "can.virtual"}},
    "devices": {
        "axis": {
            "kind": "cia402.drive",
            "node_id": 3,
            "links": {"can": "can"},
            "faults": [{"what": "overtemperature"}],
        }
    },
}


@pytest.fixture(scope="module")
def counters(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    folder = tmp_path_factory.mktemp("counters")
    (folder / "table.yaml").write_text(TABLE)
    file = folder / "counters.yaml"
    file.write_text(json.dumps(RIG))
    with ServedRig(file) as rig:
        yield rig


def field(page: Page, name: str) -> Locator:
    return page.get_by_role("textbox", name=name, exact=True)


def test_a_front_has_all_digits_of_a_whole_number_and_an_empty_field_is_no_zero(
    browser: Browser, counters: ServedRig
) -> None:
    with opened(browser, counters, path="/device/store") as page:
        expect(field(page, "date")).to_have_value("20260131")
        expect(field(page, "total")).to_have_value(str(LARGE))
        field(page, "date").fill("")
        field(page, "date").press("Enter")
        field(page, "ratio").fill("0.5")
        field(page, "ratio").press("Enter")
        expect(field(page, "ratio")).to_have_value("0.5")
        field(page, "total").fill(str(LARGE + 2))
        field(page, "total").press("Enter")
        expect(field(page, "total")).to_have_value(str(LARGE + 2))
        assert counters.value("store/total") == LARGE + 2
        expect(field(page, "date")).to_have_value("20260131")
        assert counters.value("store/date") == 20260131


def test_a_whole_number_of_64_bits_is_shown_and_written_with_all_its_digits(
    browser: Browser, counters: ServedRig
) -> None:
    counters.ask("device/store/set", {"values": {"total": LARGE}})
    with opened(browser, counters, path="/values/store") as page:
        page.get_by_role("button", name=f"total, {LARGE}, change").click()
        page.get_by_role("textbox", name="new value").fill(str(LARGE + 2))
        page.get_by_role("button", name="Write").click()
        expect(page.get_by_role("button", name=f"total, {LARGE + 2}, change")).to_be_visible()
        assert counters.value("store/total") == LARGE + 2


def test_a_float_that_is_written_without_a_change_keeps_all_its_digits(browser: Browser, counters: ServedRig) -> None:
    with opened(browser, counters, path="/values/store") as page:
        page.get_by_role("button", name="factor, 0.1234568, change").click()
        expect(page.get_by_role("textbox", name="new value")).to_have_value(str(FINE))
        page.get_by_role("button", name="Write").click()
        expect(page.get_by_role("dialog")).to_have_count(0)
        assert counters.value("store/factor") == FINE


def test_what_is_typed_into_the_trigger_stays_while_samples_come(browser: Browser, counters: ServedRig) -> None:
    with opened(browser, counters, path="/scope/store/turns,store/ratio") as page:
        page.get_by_role("combobox", name="Trigger", exact=True).select_option("edge of a signal")
        newest = page.locator(".scope-values tbody td").first
        level = page.get_by_role("spinbutton", name="Level")
        level.fill("")
        for digit in "73999":
            before = newest.inner_text()
            level.press(digit)
            expect(newest).not_to_have_text(before)
        level.press("Enter")
        level_of = "JSON.parse(sessionStorage.getItem('scope:counters')).setup.trigger.level"
        until(lambda: page.evaluate(level_of) == 73999)  # before, it is the middle of what was there
        expect(level).to_have_value("73999")


def test_cursors_have_all_digits_of_whole_numbers(browser: Browser, counters: ServedRig) -> None:
    counters.ask("device/store/set", {"values": {"total": LARGE}})
    with opened(browser, counters, path="/scope/store/turns,store/total") as page:
        page.get_by_role("combobox", name="Window", exact=True).select_option("100 ms")
        newest = page.locator(".scope-values tbody td").first
        expect(page.locator(".scope-values tbody td").nth(1)).to_contain_text("9.007")
        for _ in range(2):
            before = newest.inner_text()
            expect(newest).not_to_have_text(before)
        page.get_by_role("button", name="Stop", exact=True).click()
        page.get_by_role("button", name="Cursors").click()
        page.get_by_label("Cursor A").fill("950")  # near the end, as `total` is recorded for a shorter time
        page.get_by_label("Cursor B").fill("990")
        cells = page.locator(".scope-values tbody td")
        expect(cells).to_have_count(6)
        expect(cells.nth(5)).not_to_have_text("no value")
        first, second, between, *totals = cells.all_inner_texts()
        assert int(second) - int(first) == int(between) > 0
        assert int(first) > 73113480
        assert totals == [str(LARGE), str(LARGE), "0"]


def test_the_words_of_a_drive_have_hexadecimal_digits_as_in_its_manual(browser: Browser, tmp_path: Path) -> None:
    """Overtemperature of the drive is 4310h (CiA 402-2), and 0218h is the status word of a fault with voltage."""
    file = tmp_path / "drive.yaml"
    file.write_text(json.dumps(DRIVE))
    with ServedRig(file) as rig, opened(browser, rig, path="/device/axis") as page:
        facts = page.locator(".fact")
        expect(facts.filter(has_text="status word")).to_contain_text("0218h")
        expect(facts.filter(has=page.get_by_text("error", exact=True))).to_contain_text("4310h")


def test_a_number_on_a_card_is_short_and_has_the_digits_that_a_person_reads(
    browser: Browser, counters: ServedRig
) -> None:
    shown = "async values => { const { show } = await import('/static/picture/life.js'); return values.map(show); }"
    texts = {
        0: "0", 1.5: "1.500", -12.345: "-12.35", 0.0011523: "0.00115", 1234.5: "1235", 2719755: "2\u202f719\u202f755",
        82_614_321: "82.6 M", -165_234_000: "-165 M", 12_000_000: "12.0 M", 4_294_967_295: "4.29 G", 1e15: "1000 T",
        999_999_999: "1000 M", float("inf"): "Infinity",
    }  # fmt: skip
    with opened(browser, counters) as page:
        assert page.evaluate(shown, list(texts)) == list(texts.values())
