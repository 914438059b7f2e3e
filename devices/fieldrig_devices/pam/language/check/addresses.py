"""Addresses: of nodes on the ring, and of inputs and outputs in their nodes (table 2-2, appendices D and E).

An address that does not exist is a mistake, and so are two nodes or two outputs at one address, and two axes of one
ST1.  Several inputs may read one terminal.  The numbers of keys and LEDs are those of a keyboard, which the manual does
not give.
"""

from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from fieldrig_devices.pam.language.check.given import Given
from fieldrig_devices.pam.language.check.symbols import Names
from fieldrig_devices.pam.language.items import Declaration, Program
from fieldrig_devices.pamring.registers import register_at
from fieldrig_devices.smart_io.addresses import POSITIONS, exists, place_of
from fieldrig_devices.st1.addresses import INPUT_ADDRESSES, OUTPUT_ADDRESSES

LAST_NODE: Final = 255
_CHANNELS: Final = ("BINARY_INPUT", "DIGITAL_INPUT", "COUNTER_INPUT", "BINARY_OUTPUT", "DIGITAL_OUTPUT")
_OUTPUTS: Final[Mapping[str, str]] = {
    "BINARY_OUTPUT": "output",
    "DIGITAL_OUTPUT": "output",
    "LED_OUTPUT": "LED",
    "ANALOG_OUTPUT": "analog output",
    "D7SEG_OUTPUT": "display",
    "PAM_ANALOG_OUTPUT": "analog output of the PAM",
}
"""The sorts of outputs: two outputs of one sort have different addresses."""


class _Fixed(NamedTuple):
    """The addresses of a kind that do not depend on its node."""

    is_right: Callable[[int], bool]
    expected: str


_FIXED: Final[Mapping[str, _Fixed]] = {
    "ENCODER": _Fixed(lambda address: register_at(address) is not None, "0 to 4, or a bank with a code (table 2-2)"),
    "ANALOG_OUTPUT": _Fixed(lambda address: address == 1, "1, the analog output of a SMART_IO"),
    "D7SEG_OUTPUT": _Fixed(lambda address: address == 1, "1, the display of a SMART_IO"),
    "PAM_ANALOG_OUTPUT": _Fixed(lambda address: address in (0, 1), "0 or 1, the analog outputs of the PAM"),
    "LED_OUTPUT": _Fixed(lambda address: address > 0, "1 or more"),
    "KEY_INPUT": _Fixed(lambda address: address > 0, "1 or more"),
}


def check_addresses(program: Program, names: Names) -> None:
    """Report addresses that do not exist, and those that two nodes or two outputs have."""
    declarations = [Given(item) for item in program.items if isinstance(item, Declaration)]
    groups = {item.name: item.integer("NUMBER") for item in declarations if item.kind == "NODES_GROUP"}
    types = {item.name: item.text("TYPE") for item in declarations if item.kind == "NODE"}
    owners: dict[tuple[str, str, int], str] = {}
    axes: dict[str, str] = {}
    for item in declarations:
        if item.kind == "AXIS":
            _is_alone(item, axes, names)
        address = item.integer("ADDRESS")
        if address is None or address < 0:  # a negative one has a message already
            continue
        if item.kind == "NODE":
            count = item.integer("NUMBER") or groups.get(item.text("NODES_GROUP")) or 1
            if _is_on_the_ring(item, address, count, names):
                _occupy(item, ("", "node"), range(address, address + count), owners, names)
        elif _exists(item, address, types.get(item.text("NODE"), ""), names) and item.kind in _OUTPUTS:
            taken = range(address, address + (item.integer("BITS") or 1))
            _occupy(item, (item.text("NODE"), _OUTPUTS[item.kind]), taken, owners, names)


def _is_alone(item: Given, axes: dict[str, str], names: Names) -> None:
    """Report a second axis of a node: an ST1 has one (lines 1084 and 1118)."""
    node = item.text("NODE")
    other = axes.setdefault(node, item.name) if node else item.name
    if other != item.name:
        names.wrong(item.place, f"{item.name} and {other} are axes of {node}", "another ST1 for each axis")


def _is_on_the_ring(item: Given, address: int, count: int, names: Names) -> bool:
    last = address + count - 1
    if address >= 1 and last <= LAST_NODE:
        return True
    shown = f"ADDRESS is {address}" if count == 1 else f"the addresses are {address} to {last}"
    names.wrong(item.place, shown, f"1 to {LAST_NODE}")
    return False


def _exists(item: Given, address: int, node_type: str, names: Names) -> bool:
    """Report an address that the node does not have."""
    is_on_input = item.kind == "KEY_INPUT" and item.text("ON") == "BINARY_INPUT"
    if item.kind in _CHANNELS or is_on_input:
        expected = _channels(item, address, node_type)
    else:
        fixed = _FIXED.get(item.kind)
        expected = "" if fixed is None or fixed.is_right(address) else fixed.expected
    if expected:
        names.wrong(item.place, f"ADDRESS is {address}", expected)
    return not expected


def _channels(item: Given, address: int, node_type: str) -> str:
    """Return what was expected instead of the address of an input or output; nothing if it is right."""
    is_output = item.kind in _OUTPUTS
    if node_type == "ST1":
        known = OUTPUT_ADDRESSES if is_output else INPUT_ADDRESSES
        expected = "201 to 208, the outputs of an ST1" if is_output else "101, 102 or 201 to 216, the inputs of an ST1"
        return "" if address in known else expected
    if node_type != "SMART_IO":
        return ""  # its node is a mistake already
    if not exists(address):
        return "a module from 1 to 16 and a position from 01 to 12 of a SMART_IO, such as 101 to 112 or 1601 to 1612"
    bits = item.integer("BITS") or 1
    last = POSITIONS - place_of(address)[1] + 1
    return "" if bits <= last or bits > POSITIONS else f"an address with {bits} positions up to the end of its module"


def _occupy(
    item: Given, what: tuple[str, str], taken: range, owners: dict[tuple[str, str, int], str], names: Names
) -> None:
    node, sort = what
    for address in taken:
        other = owners.setdefault((node, sort, address), item.name)
        if other != item.name:
            names.wrong(
                item.place, f"{item.name} and {other} have the address {address}", f"another one for each {sort}"
            )
            return
