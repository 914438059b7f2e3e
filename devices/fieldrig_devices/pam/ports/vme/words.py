"""The words of a VME DualPort by name: headers, commands with their codes, and the blocks of the FIFOs by variable.

Source: sections 11.2 and 11.3 (tables 13-8 and 13-9).  The key of an input is its place in the application, from 1;
that of an output is learnt from DEF_OUT, whose parameters the master writes before the command.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.pam.language.ports import ALL_ITEMS, PortVariable
from fieldrig_devices.pam.ports.panel import VME_PANEL
from fieldrig_devices.pam.ports.vme.layout import (
    ACKNOWLEDGE,
    BLOCK_WORDS,
    BLOCKS,
    BODIES,
    COMMAND,
    IN_HEADER,
    OUT_HEADER,
    PAM_PARAMETERS,
    SYNCHRO,
    VME_PARAMETERS,
    WATCHDOG,
    Answer,
    Command,
    item_on_wire,
    value_of,
)
from fieldrig_devices.pam.ports.words import PANEL, Piece, shown

FIELDS: Final = ("OFFSET", "HEAD", "TAIL", "MAX_BLOC_NUMBER", "BLOC_SIZE")
SIDES: Final = {IN_HEADER: "input", OUT_HEADER: "output"}
PARAMETERS: Final = 5
"""Words of PAM PARAMETERS that an answer can have."""
MOST_KEYS: Final = 4_096
COMMANDS: Final = {int(command): command.name for command in Command}
ANSWERS: Final = {int(answer): answer.name for answer in Answer}
LABELS: Final = {
    **{header + at: f"{side.upper()} {name}" for header, side in SIDES.items() for at, name in enumerate(FIELDS)},
    WATCHDOG: "WATCHDOG",
    SYNCHRO: "SYNCHRO",
    COMMAND: "COMMAND",
    **{VME_PARAMETERS + at: f"VME PARAMETER {at + 1}" for at in range(3)},
    ACKNOWLEDGE: "ACKNOWLEDGE",
    **{PAM_PARAMETERS + at: f"PAM PARAMETER {at + 1}" for at in range(PARAMETERS)},
    **{VME_PANEL // 2 + at: f"panel {name}" for at, name in enumerate(PANEL)},
}


class VmeWords:
    """The map of one VME DualPort.  Implements `WordMap`."""

    def __init__(self, variables: Sequence[PortVariable], first_item: int = 0) -> None:
        """`first_item` is the index of the first item of a multiple variable in blocks."""
        self._first_item = first_item
        self._inputs = dict(enumerate((each for each in variables if each.is_input), 1))
        self._by_crc = {each.crc: each for each in variables if not each.is_input}
        self._outputs: dict[int, PortVariable] = {}
        """The outputs by the keys of the master."""
        self._parameters = [0, 0, 0]

    def label(self, word: int) -> str:
        block = _block_of(word)
        if block is None:
            return LABELS.get(word, str(word))
        header, number, _ = block
        return f"{SIDES[header]} block {number}"

    def piece(self, word: int, values: Sequence[int]) -> tuple[int, Piece]:
        block = _block_of(word)
        if block is None:
            return 1, self._cell(word, values[0])
        header, number, at = block
        kind, name = f"{SIDES[header]} block", f"{SIDES[header]} block {number}"
        if at == 0 and len(values) >= BLOCK_WORDS:
            return BLOCK_WORDS, Piece(kind, name, self._block(header, tuple(values[:BLOCK_WORDS])))
        return 1, Piece(kind, f"{name} word {at}", f"{values[0]:04X}h")

    def _cell(self, word: int, value: int) -> Piece:
        name = self.label(word)
        if word == COMMAND:
            return Piece("command", name, self._command(value))
        if word == ACKNOWLEDGE:
            return Piece("acknowledge", name, ANSWERS.get(value, str(value)))
        if VME_PARAMETERS <= word < VME_PARAMETERS + 3:
            self._parameters[word - VME_PARAMETERS] = value
        if word >= VME_PANEL // 2:
            return Piece("panel" if word in LABELS else "words", name, f"{value:04X}h")
        is_header = word < WATCHDOG
        kind = "header" if is_header else "parameter" if "PARAMETER" in name else name.lower()
        return Piece(kind, name, str(value) if is_header else f"{value:04X}h")

    def _command(self, code: int) -> str:
        if code != Command.DEF_OUT:
            return COMMANDS.get(code, str(code))
        crc, low, high = self._parameters
        variable, key = self._by_crc.get(crc), high << 16 | low
        if variable is not None and (len(self._outputs) < MOST_KEYS or key in self._outputs):
            self._outputs[key] = variable
        return f"DEF_OUT {f'CRC {crc:04X}h' if variable is None else variable.name} with key {key}"

    def _block(self, header: int, words: tuple[int, ...]) -> str:
        """Return the variable and its value in a block."""
        key, index, value = words[0], words[2], words[3:]
        if header == OUT_HEADER:
            key |= words[1] << 16
        variable = (self._inputs if header == IN_HEADER else self._outputs).get(key)
        if variable is None:
            return f"key {key} index {index}: {' '.join(f'{word:04X}h' for word in value)}"
        return f"{variable.name}{self._item(variable, index)} {shown(value_of(variable.kind, value))}"

    def _item(self, variable: PortVariable, index: int) -> str:
        if not variable.is_multiple:
            return ""
        return "[all]" if index == ALL_ITEMS else f"[{item_on_wire(variable, index, self._first_item) + 1}]"


def _block_of(word: int) -> tuple[int, int, int] | None:
    """Return the FIFO, the number of the block and the word in it; None outside of the FIFOs."""
    for header, body in BODIES.items():
        number, at = divmod(word - body, BLOCK_WORDS)
        if 0 <= number < BLOCKS:
            return header, number, at
    return None
