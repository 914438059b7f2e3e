"""LSS messages in words: services, identity, node-ID, bit timing and errors.

Source: CiA 305 version 3.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig_devices.canopen.bit_timing import BIT_RATES
from fieldrig_devices.canopen.lss import DELAY, DONE, NOT_STORED, NOT_SUPPORTED, NUMBER, RESET_SCAN, SCAN, SIZE, State

SERVICES: Final[Mapping[int, str]] = {
    0x04: "switch state global",
    0x11: "configure node-ID",
    0x13: "configure bit timing",
    0x15: "activate bit timing",
    0x17: "store configuration",
    0x40: "select vendor-ID",
    0x41: "select product code",
    0x42: "select revision number",
    0x43: "select serial number",
    0x44: "selected",
    0x46: "identify vendor-ID",
    0x47: "identify product code",
    0x48: "identify revision number from",
    0x49: "identify revision number to",
    0x4A: "identify serial number from",
    0x4B: "identify serial number to",
    0x4C: "identify non-configured",
    0x4F: "identify slave",
    0x50: "non-configured slave",
    0x51: "fastscan",
    0x5A: "inquire vendor-ID",
    0x5B: "inquire product code",
    0x5C: "inquire revision number",
    0x5D: "inquire serial number",
    0x5E: "inquire node-ID",
}
PARTS: Final = ("vendor-ID", "product code", "revision number", "serial number")
ERRORS: Final[Mapping[int, Mapping[int, str]]] = {
    0x11: {DONE: "done", 1: "node-ID out of range"},
    0x13: {DONE: "done", 1: "bit rate not supported"},
    0x17: {DONE: "done", NOT_SUPPORTED: "not supported", NOT_STORED: "not stored"},
}
MODES: Final = {state.value: state.name.lower() for state in State}
OWN_ERROR: Final = 0xFF
STANDARD_TABLE: Final = 0
UNCONFIGURED: Final = 0xFF


def lss_words(data: bytes, *, is_request: bool) -> str:
    """Return service and content of an LSS message; what breaks the form of its service is in hexadecimal."""
    service = SERVICES.get(data[0], f"service {data[0]}") if data else ""
    say = (REQUESTS if is_request else ANSWERS).get(data[0]) if len(data) == SIZE else None
    rest = data[1:].hex(" ").upper() if say is None else say(data)
    return f"{service} {rest}".strip()


def _mode(data: bytes) -> str:
    return MODES.get(data[1], f"{data[1]}")


def _number(data: bytes) -> str:
    return f"{NUMBER.unpack(data)[1]:08X}h"


def _node_id(data: bytes) -> str:
    return "none" if data[1] == UNCONFIGURED else f"{data[1]}"


def _bit_timing(data: bytes) -> str:
    table, index = data[1], data[2]
    if table == STANDARD_TABLE and index in BIT_RATES:
        return f"{BIT_RATES[index] // 1000} kbit/s"
    return f"entry {index} of table {table}"


def _delay(data: bytes) -> str:
    return f"in {DELAY.unpack(data)[0]} ms"


def _scan(data: bytes) -> str:
    _, number, checked, part, following = SCAN.unpack(data)
    if checked == RESET_SCAN:
        return "of all non-configured"
    name = PARTS[part] if part < len(PARTS) else f"part {part}"
    then = PARTS[following] if following < len(PARTS) else f"part {following}"
    return f"{name} {number:08X}h from bit {checked}" + (f", then {then}" if following != part else "")


def _outcome(data: bytes) -> str:
    if data[1] == OWN_ERROR:
        return f"error {data[2]} of the maker"
    return ERRORS[data[0]].get(data[1], f"error {data[1]}")


def _nothing(data: bytes) -> str:
    return ""


REQUESTS: Final[Mapping[int, Callable[[bytes], str]]] = {
    0x04: _mode,
    0x11: _node_id,
    0x13: _bit_timing,
    0x15: _delay,
    0x17: _nothing,
    **dict.fromkeys((*range(0x40, 0x44), *range(0x46, 0x4C)), _number),
    0x4C: _nothing,
    0x51: _scan,
    **dict.fromkeys(range(0x5A, 0x5F), _nothing),
}
ANSWERS: Final[Mapping[int, Callable[[bytes], str]]] = {
    **dict.fromkeys((0x11, 0x13, 0x17), _outcome),
    **dict.fromkeys((0x44, 0x4F, 0x50), _nothing),
    **dict.fromkeys(range(0x5A, 0x5E), _number),
    0x5E: _node_id,
}
