"""The telegrams of a PAM's RS422 line in words: the command, and the variables of the application by name.

Source: docs/devices/pam/pam-rs422.md.  The key of an input is its place in the application, from 1, and that of an
output is learnt from DEF_OUT of the master (section 13.1).
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from fieldrig.points.values import show_number
from fieldrig_devices.line_names.described import Part
from fieldrig_devices.pam.language.ports import ALL_ITEMS, PortVariable
from fieldrig_devices.pam.ports.rs422.codec import FramedCodec, LineFault
from fieldrig_devices.pam.ports.rs422.messages import CLASS_NUMBERS, CLASS_OF, FIELDS, Code, Message, Result

MOST_ENDS: Final = 8
MOST_KEYS: Final = 4_096
"""Variables whose keys are remembered."""
CLASSES: Final = {number: kind for kind, number in CLASS_NUMBERS.items()}
_CODES: Final = {int(code): code.name.replace("_", " ") for code in Code}
_RESULTS: Final = {int(result): result.name.replace("_", " ") for result in Result}


class Rs422Reader:
    """Reads the bytes of a line to a PAM."""

    def __init__(self, pam: str, variables: Sequence[PortVariable]) -> None:
        """`pam` is the name of the PAM in the rig, and `variables` are those of its RS422 port."""
        self._pam = pam
        self._by_crc = {variable.crc: variable.name for variable in variables}
        self._codecs: dict[str, FramedCodec] = {}
        inputs = (variable.name for variable in variables if variable.is_input)
        self._keys = {(True, key): name for key, name in enumerate(inputs, 1)}
        """The names of variables, by whether they go to the PAM, and their key."""

    def __call__(self, sender: str, data: bytes) -> Sequence[Part]:
        end = sender if sender in self._codecs or len(self._codecs) < MOST_ENDS else ""
        found = self._codecs.setdefault(end, FramedCodec()).decode(data)
        return [self._part(each, is_input=sender != self._pam) for each in found]

    def _part(self, found: Message | LineFault, is_input: bool) -> Part:
        if isinstance(found, LineFault):
            return "line fault", found.name.lower().replace("_", " ")
        if found.code not in FIELDS:
            return "unknown command", ""
        code = Code(found.code)
        show = self._exchange if code in CLASS_OF else _SHOWN.get(code, _plain)
        return _CODES[code], show(self, found, is_input)

    def _exchange(self, _: "Rs422Reader", message: Message, is_input: bool) -> str:
        key, index, value = message.values
        name = self._keys.get((is_input, int(key)), f"key {int(key)}")
        item = " of all items" if index == ALL_ITEMS else f" item {int(index)}" if index else ""
        return f"{name}{item} = {show_number(value)}"

    def define(self, is_input: bool, crc: int, key: int) -> str:
        """Remember the key of a variable, and return its name."""
        name = self._by_crc.get(crc, f"CRC {crc:04X}h")
        if len(self._keys) < MOST_KEYS or (is_input, key) in self._keys:
            self._keys[is_input, key] = name
        return name


def _plain(reader: Rs422Reader, message: Message, is_input: bool) -> str:
    return ""


def _def_out(reader: Rs422Reader, message: Message, is_input: bool) -> str:
    crc, key = map(int, message.values)
    return f"{reader.define(False, crc, key)}, key {key}"


def _def_in(reader: Rs422Reader, message: Message, is_input: bool) -> str:
    crc, key, kind, items, period_ms = map(int, message.values)
    name = reader.define(True, crc, key)
    return f"{name}, key {key}, {CLASSES.get(kind, f'class {kind}')}, {items} items, every {period_ms} ms"


def _ack(reader: Rs422Reader, message: Message, is_input: bool) -> str:
    command, result, kind, items = map(int, message.values)
    asked = _CODES.get(command, f"command {command:02X}h")
    told = _RESULTS.get(result, f"result {result}")
    output = f", {CLASSES.get(kind, f'class {kind}')}, {items} items" if kind else ""
    return f"{asked}: {told}{output}"


_SHOWN: Final[Mapping[int, Callable[[Rs422Reader, Message, bool], Any]]] = {
    Code.DEF_OUT: _def_out,
    Code.DEF_IN: _def_in,
    Code.ACK: _ack,
}
