"""The small lab in containers: what the machine of test_compose.py has not."""

import re
from collections.abc import Iterator
from urllib.parse import urlsplit
from urllib.request import HTTPCookieProcessor, build_opener

import can
import pytest
from compose_stack import Stack, node_of, shut_in, stack_of
from lab_process import IO32
from pymodbus import FramerType
from pymodbus.client import ModbusTcpClient

pytestmark = [pytest.mark.docker, pytest.mark.timeout(3600)]

PARTS = {"rig", "can0", "tank", "io", "sensor", "drive"}
PORTS = ("SOCKETCAND", "SLCAN", "MODBUS", "RTU", "PAGE")


@pytest.fixture(scope="module")
def stack() -> Iterator[Stack]:
    with stack_of("compose.lab.yaml", PORTS) as stack:
        yield stack


def test_every_part_runs_and_is_shut_in(stack: Stack) -> None:
    containers = stack.containers()
    assert containers.keys() == PARTS
    assert [name for name, container in containers.items() if not shut_in(container)] == []


def test_modbus_master_starts_the_pump_and_the_canopen_master_sees_the_tank_fill(stack: Stack) -> None:
    with (
        stack.network("can0", "SOCKETCAND") as network,
        ModbusTcpClient("127.0.0.1", port=stack.ports["MODBUS"], timeout=20) as drive,
    ):
        level_tenth_mm = node_of(network, 5, IO32).sdo[0x6401][1]
        before = level_tenth_mm.raw
        assert not drive.write_register(0, 1000, device_id=1).isError()  # 100.0 %
        assert not drive.write_coil(0, True, device_id=1).isError()
        stack.until(lambda: level_tenth_mm.raw >= before + 40, "4 mm, a second's worth")
        assert not drive.write_coil(0, False, device_id=1).isError()


def test_what_has_a_pty_in_the_lab_has_a_port_here(stack: Stack) -> None:
    with ModbusTcpClient("127.0.0.1", port=stack.ports["RTU"], framer=FramerType.RTU, timeout=20) as drive:
        assert drive.read_coils(0, count=2, device_id=1).bits[:2] == [False, False]
    with can.Bus(f"socket://127.0.0.1:{stack.ports['SLCAN']}", "slcan", bitrate=250_000) as bus:
        bus.send(can.Message(arbitration_id=0x605, data=bytes.fromhex("40 00 10 00 00 00 00 00"), is_extended_id=False))
        stack.until(lambda: _is_answer(bus.recv(1)), "the I/O node answers")


def test_the_page_is_at_the_address_that_is_printed(stack: Stack) -> None:
    printed = re.search(r"page to look: +(\S+)", stack.compose("logs", "--no-color", "rig"))
    assert printed is not None
    assert urlsplit(printed[1]).netloc == f"127.0.0.1:{stack.ports['PAGE']}"
    browser = build_opener(HTTPCookieProcessor())
    with browser.open(printed[1], timeout=60) as page:
        assert (page.status, page.url) == (200, printed[1].partition("?")[0])
        assert b"<!doctype html>" in page.read()


def _is_answer(message: can.Message | None) -> bool:
    """True for the expedited SDO response with object 1000h of the I/O node, 000F0191h."""
    return message is not None and bytes(message.data) == bytes.fromhex("43 00 10 00 91 01 0f 00")
