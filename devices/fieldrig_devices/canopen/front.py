"""The front of a CANopen node: the LEDs of CiA 303-3, and the terminals of CiA 401 or the objects of its profile."""

from collections.abc import Iterator, Mapping
from typing import Final, Literal

from fieldrig.front import Clamp, Front, Group, Led, Number, Part, Plate, Text
from fieldrig_devices.canopen.datatypes import Boolean, Integer, Real
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.service import State
from fieldrig_devices.canopen.variable import Variable

_ON, _BLINKS = (State.OPERATIONAL.name.lower(),), (State.PRE_OPERATIONAL.name.lower(),)
RUN_AND_ERR: Final = (
    Led("RUN", "nmt.state", "on: operational; blinks: pre-operational", lit=_ON, blinks=_BLINKS),
    Led("ERR", "error_register", "an error is pending (1001h)", colour="red"),
)
"""The LEDs of CiA 303-3, without the rhythms by which that tells further states apart."""

Side = Literal["in", "out"]
# CiA 401: first object of a block, side, bits of an entry; an entry of an analog terminal is a whole number.
_DIGITAL: Final[dict[int, tuple[Side, int]]] = {
    0x6000: ("in", 8), 0x6020: ("in", 1), 0x6100: ("in", 16), 0x6120: ("in", 32),
    0x6200: ("out", 8), 0x6220: ("out", 1), 0x6300: ("out", 16), 0x6320: ("out", 32),
}  # fmt: skip
_ANALOG: Final[dict[int, Side]] = {
    0x6400: "in", 0x6401: "in", 0x6402: "in", 0x6403: "in", 0x6404: "in",
    0x6410: "out", 0x6411: "out", 0x6412: "out", 0x6413: "out", 0x6414: "out",
}  # fmt: skip
_CIA_401: Final = 401
_PROFILE: Final = range(0x6000, 0xA000)
_MOST: Final = 64
"""Most terminals, and most objects, on a front."""


def front_of(dictionary: Dictionary, profile: int, wires: Mapping[tuple[int, int, int | None], str]) -> Front:
    """Return the front of a node with the objects of a dictionary; `profile` is the number of its device profile.

    `wires` are those that drive inputs, by index, sub-index and bit; None for a whole object.
    """
    state = [
        Text("state", "nmt.state", good=_ON, bad=("stopped",)),
        Text("last error", "emcy.code", "code of the last EMCY", names=((0, "none"),), hex_digits=4),
    ]
    groups = [Group([*RUN_AND_ERR, *state], "node")]
    parts: dict[str, list[Part]] = {}
    for variable in dictionary:
        if variable.index in _PROFILE:
            for title, part in _parts(variable, profile, wires):
                parts.setdefault(title, []).append(part)
    groups += [Group(of_title[:_MOST], title) for title, of_title in parts.items()]
    return Front(Plate("", "CANopen node", {"node-ID": "node_id"}), groups)


def _parts(
    variable: Variable, profile: int, wires: Mapping[tuple[int, int, int | None], str]
) -> Iterator[tuple[str, Part]]:
    index, sub, key = variable.index, variable.subindex, variable.key
    is_count = sub == 0 and variable.name.lower().startswith(("number of", "highest sub"))
    if is_count or not isinstance(variable.type, Boolean | Integer | Real):
        return
    if profile != _CIA_401:
        yield "objects", Number(variable.name, key, f"object {key}")
    elif index in _DIGITAL:
        side, bits = _DIGITAL[index]
        for bit in range(bits):
            label = f"{(sub - 1) * bits + bit}" if sub else f"{bit}"
            about, is_set = _of_wire(f"bit {bit} of {key}", side, wires.get((index, sub, bit)))
            clamp = Clamp(label, key, about, side=side, is_set=is_set, bit=bit if bits > 1 else None)
            yield f"digital {side}puts", clamp
    elif index in _ANALOG:
        side = _ANALOG[index]
        about, is_set = _of_wire(f"object {key}", side, wires.get((index, sub, None)))
        yield f"analog {side}puts", Clamp(str(max(sub - 1, 0)), key, about, side=side, is_set=is_set)


def _of_wire(about: str, side: Side, wire: str | None) -> tuple[str, bool]:
    """Return the description of a terminal, and whether a person sets it."""
    return (f"{about}, driven by the wire {wire}", False) if wire else (about, side == "in")
