"""What a master may order the card to do: by SDO command, by control byte in a PDO, by storing of parameters.

Source: ours (docs/arp-can.md); digest chapter 20 (control word), CiA 301 7.5.2.10 and 7.5.2.11 (1010h, 1011h).
A command acts each time it is written; a bit of the control byte when it rises, since PDOs repeat themselves.
"""

from collections.abc import Callable
from enum import IntEnum, IntFlag
from typing import Final

from fieldrig_devices.arp.can import objects
from fieldrig_devices.arp.outside import Outside
from fieldrig_devices.arp.parameters import PARAMETERS, ParameterValues
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.parameters import RESTORE, STORE
from fieldrig_devices.canopen.variable import Variable


class Command(IntEnum):
    """2100h."""

    RUN = 1
    STOP = 2
    RESET = 3  # Ctrl-F2
    SAVE = 4


class Control(IntFlag):
    """2101h, in the order of doing: stop and run together start anew."""

    STOP = 0x02
    RESET = 0x04
    RUN = 0x01


ORDERED: Final = ((Control.STOP, Command.STOP), (Control.RESET, Command.RESET), (Control.RUN, Command.RUN))
WITH_OURS: Final = (1, 4)
"""Sub-indices of 1010h and 1011h that mean the manufacturer's parameters too."""


def connect(dictionary: Dictionary, card: Outside) -> None:
    """Let the dictionary's objects command `card`."""
    command = dictionary.find(objects.COMMAND, 0)
    command.writer = lambda data: _do(card, Command(data[0]))
    control = dictionary.find(objects.CONTROL, 0)
    control.writer = lambda data: _on_control(card, control, data)
    for subindex in WITH_OURS:
        _with_ours(dictionary.find(STORE, subindex), card, _in_ram)
        _with_ours(dictionary.find(RESTORE, subindex), card, _defaults)


def _do(card: Outside, command: Command) -> None:
    is_done = True
    if command is Command.RUN:
        is_done = card.run_program()
    elif command is Command.STOP:
        is_done = card.stop_program()
    elif command is Command.RESET:
        card.reset()
    elif not card.save_parameters(_in_ram(card)):
        raise Abort(Code.HARDWARE)
    if not is_done:
        raise Abort(Code.DEVICE_STATE)


def _on_control(card: Outside, control: Variable, data: bytes) -> None:
    rising = data[0] & ~control.number
    control.set(data)  # also what is refused counts as seen: nothing starts later by itself
    for bit, command in ORDERED:
        if rising & bit:
            _do(card, command)


def _with_ours(entry: Variable, card: Outside, values: Callable[[Outside], ParameterValues]) -> None:
    """The node checks the signature and writes; ours go with that, so that all is kept or nothing."""
    first = entry.writer
    assert first is not None, "the node stores parameters"

    def write(data: bytes) -> None:
        with card.saving(values(card)):
            first(data)

    entry.writer = write


def _in_ram(card: Outside) -> ParameterValues:
    return _other_than_in_flash(card, lambda group, number: card.parameters.ram[group][number])


def _defaults(card: Outside) -> ParameterValues:
    """CiA 301: in force from the next start; until then RAM stays as it is."""
    return _other_than_in_flash(card, lambda group, number: PARAMETERS[group][number].default)


def _other_than_in_flash(card: Outside, value: Callable[[int, int], int]) -> ParameterValues:
    flash = card.parameters.flash
    wanted = {(group, number): value(group, number) for group, table in enumerate(PARAMETERS) for number in table}
    return {(group, number): raw for (group, number), raw in wanted.items() if flash[group][number] != raw}
