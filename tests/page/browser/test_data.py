"""Values, traffic and faults in a browser: by what a person does, beside masters from outside."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import canopen
import pytest
from axe_playwright_python.sync_playwright import Axe
from browser_page import ServedRig, opened
from playwright.sync_api import Browser, expect
from pymodbus.client import ModbusTcpClient

from fieldrig.testing import free_port

CONFIGS = Path(__file__).parents[3] / "configs"
SCHEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")

pytestmark = pytest.mark.real

PORTS = {"can": free_port(), "tcp": free_port()}


@pytest.fixture(scope="module")
def lab() -> Iterator[ServedRig]:
    can, tcp = PORTS["can"], PORTS["tcp"]
    with ServedRig(
        CONFIGS / "lab.yaml",
        None,
        f"--set=buses.can0.socketcand=127.0.0.1:{can}",
        f"--set=buses.mb_tcp.listen=127.0.0.1:{tcp}",
    ) as rig:
        yield rig


@pytest.fixture
def master() -> Iterator[ModbusTcpClient]:
    with ModbusTcpClient("127.0.0.1", port=PORTS["tcp"], timeout=1, retries=0) as client:
        yield client


@pytest.fixture
def network(lab: ServedRig) -> Iterator[canopen.Network]:
    network = canopen.Network()
    network.connect(interface="socketcand", host="127.0.0.1", port=PORTS["can"], channel="can0")
    yield network
    network.disconnect()


def test_a_register_is_found_by_name_and_a_value_beyond_its_limits_is_refused_with_the_reason(
    browser: Browser, lab: ServedRig, master: ModbusTcpClient
) -> None:
    with opened(browser, lab, path="/values/drive") as page:
        page.get_by_label("find").fill("set point")
        expect(page.locator(".rows tbody tr")).to_have_count(1)
        page.get_by_role("button", name="speed_set, 0 %, change").click()
        dialog = page.get_by_role("dialog")
        expect(dialog).to_contain_text("u16, holding register 0, 0 to 100 %")
        dialog.get_by_label("new value").fill("120")
        dialog.get_by_role("button", name="Write").click()
        expect(dialog.get_by_role("alert")).to_contain_text("expected a number from 0 to 100 %, got 120")
        assert master.read_holding_registers(0, count=1, device_id=1).registers == [0]
        dialog.get_by_label("new value").fill("12.5")
        dialog.get_by_role("button", name="Write").click()
        expect(page.get_by_role("button", name="speed_set, 12.5 %, change")).to_be_visible()
        assert master.read_holding_registers(0, count=1, device_id=1).registers == [125]


def test_a_number_that_has_a_name_on_the_front_has_it_in_the_list(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab, path="/values/io") as page:
        page.get_by_label("find").fill("emcy.code")
        expect(page.get_by_role("cell", name="emcy.code, 0, change none")).to_be_visible()


def test_a_value_that_a_foreign_master_writes_appears(
    browser: Browser, lab: ServedRig, master: ModbusTcpClient
) -> None:
    with opened(browser, lab, path="/values/drive") as page:
        page.get_by_label("find").fill("level_limit")
        expect(page.get_by_role("button", name="level_limit, 1.8 m, change")).to_be_visible()
        master.write_register(2, 1500, device_id=1)
        expect(page.get_by_role("button", name="level_limit, 1.5 m, change")).to_be_visible()


def test_a_fault_given_by_the_form_reaches_a_foreign_master_and_is_cleared(
    browser: Browser, lab: ServedRig, network: canopen.Network
) -> None:
    node = canopen.RemoteNode(5, str(CONFIGS / "eds" / "io32.eds"))
    network.add_node(node)
    node.sdo.RESPONSE_TIMEOUT = 0.5
    assert node.sdo.upload(0x1000, 0)
    with opened(browser, lab, path="/faults/io") as page:
        page.get_by_label("part", exact=True).select_option("io")
        page.get_by_label("fault", exact=True).select_option("power_off")
        page.get_by_role("button", name="Give the fault").click()
        row = page.get_by_role("row", name="io 1 power_off")
        expect(row).to_contain_text("on")
        with pytest.raises(canopen.SdoCommunicationError):
            node.sdo.upload(0x1000, 0)
        expect(page.get_by_role("log")).to_contain_text("power_off")
        row.get_by_role("button", name="Clear fault 1 of io").click()
        expect(page.get_by_text("none", exact=True)).to_be_visible()
        assert node.sdo.upload(0x1000, 0)


def test_the_view_of_a_device_lists_its_emergency_messages_as_they_come(
    browser: Browser, lab: ServedRig, network: canopen.Network
) -> None:
    """8130h is "life guard error or heartbeat error" (CiA 301, table 26); node 5 is io, and 6 is another one."""
    with opened(browser, lab, path="/device/io") as page:
        section = page.get_by_role("region", name="Emergency messages")
        expect(section).to_contain_text("none since this page was opened")
        expect(page.get_by_role("heading", name="io", exact=True)).to_be_visible()
        entries = section.get_by_role("listitem")
        for _ in range(100):  # until the page hears the bus
            if entries.count() > 0:
                break
            network.send_message(0x085, bytes.fromhex("30 81 11 00 00 00 00 00"))
            page.wait_for_timeout(100)
        expect(entries.first).to_contain_text("8130h")
        network.send_message(0x086, bytes.fromhex("20 81 11 00 00 00 00 00"))
        network.send_message(0x085, bytes(8))
        expect(entries.first).to_contain_text("error reset")
        expect(section).not_to_contain_text("8120h")


def test_a_wrong_fault_is_refused_beside_its_form(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab, path="/faults") as page:
        page.get_by_label("probability").fill("two")
        page.get_by_role("button", name="Give the fault").click()
        expect(page.get_by_role("alert")).to_contain_text("probability")
        expect(page.get_by_text("none", exact=True)).to_be_visible()


def test_traffic_is_named_filtered_and_paused(browser: Browser, lab: ServedRig, network: canopen.Network) -> None:
    node = canopen.RemoteNode(5, str(CONFIGS / "eds" / "io32.eds"))
    network.add_node(node)
    with opened(browser, lab, path="/traffic/can0") as page:
        expect(page.get_by_role("button", name="can0")).to_have_attribute("aria-pressed", "true")
        expect(page.locator(".rows tbody tr").first).to_contain_text("heartbeat")  # the page hears the bus
        page.get_by_label("kind").fill("SDO")
        expect(page.get_by_role("status").filter(has_text="messages")).to_have_text("0 messages")
        node.sdo.upload(0x1008, 0)
        rows = page.locator(".rows tbody tr")
        expect(rows.first).to_contain_text("SDO read")
        expect(rows.first).to_contain_text("1008:00 Manufacturer device name")
        before = rows.count()
        page.get_by_role("button", name="Pause").click()
        node.sdo.upload(0x1000, 0)
        go_on = page.get_by_role("button", name="Go on (2 wait)")
        expect(go_on).to_be_visible()
        assert rows.count() == before
        go_on.click()
        expect(rows).to_have_count(before + 2)
        expect(rows.last).to_contain_text("1000:00 Device type = ")
        with page.expect_download() as download:
            page.get_by_role("link", name="log").click()
        log = download.value.path().read_text()
        assert "can0 605#4000100000000000" in log


def test_repeats_are_one_row_with_their_count_if_a_person_wants_it_so(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab, path="/traffic/can0") as page:
        page.get_by_label("kind").fill("heartbeat")
        rows = page.locator(".rows tbody tr:not(.gap)")
        expect(rows.nth(4)).to_be_visible()
        fold = page.get_by_role("button", name="Fold repeats")
        expect(fold).to_have_attribute("aria-pressed", "false")
        fold.click()
        expect(page.get_by_role("status").filter(has_text=re.compile(r"\d+ messages in \d rows"))).to_be_visible()
        for node in ("io", "sensor"):
            expect(rows.filter(has_text=re.compile(rf"{node}.*\d+ times")).last).to_be_visible()
        fold.click()
        expect(rows.nth(5)).to_be_visible()
        expect(page.locator(".rows .times")).to_have_count(0)


def test_of_a_long_list_only_the_rows_on_the_screen_exist(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab, path="/values/io") as page:
        expect(page.get_by_text("245 of 245 values")).to_be_visible()
        rows = page.locator(".rows tbody tr:not(.gap)")
        assert rows.count() < 60
        page.locator(".rows").evaluate("box => box.scrollTo(0, box.scrollHeight)")
        expect(page.get_by_text("the node's clock, which TIME sets")).to_be_visible()
        assert rows.count() < 60


def test_a_page_for_looking_only_has_no_field_to_write(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab, "look", path="/values/drive") as page:
        expect(page.locator(".rows tbody tr").first).to_be_visible()
        expect(page.locator(".rows button")).to_have_count(0)
    with opened(browser, lab, "look", path="/faults") as page:
        expect(page.get_by_role("heading", name="Given faults")).to_be_visible()
        expect(page.get_by_role("button")).to_have_count(0)


def test_axe_finds_no_violation_in_the_field_of_a_value(browser: Browser, lab: ServedRig) -> None:
    with opened(browser, lab, path="/values/io") as page:
        page.locator(".rows button").first.click()
        expect(page.get_by_role("dialog")).to_be_visible()
        for scheme in SCHEMES:
            page.emulate_media(color_scheme=scheme)
            found = Axe().run(page)
            assert found.violations_count == 0, found.generate_report()
