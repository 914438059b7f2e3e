"""Commands from a master to the card: by SDO, by control byte in a PDO, and by storing parameters.

Source: ours (docs/devices/arp/arp-can.md); digest chapter 20 (control word), CiA 301 7.5.2.10 and 7.5.2.11 (1010h,
1011h).  A command acts each time it is written.  A bit of the control byte acts when it rises, since PDOs are repeated.
"""

from collections.abc import Callable
from enum import IntEnum, IntFlag
from typing import Final

from fieldrig_devices.arp.can import objects
from fieldrig_devices.arp.card_access import CardAccess
from fieldrig_devices.arp.parameters import PARAMETERS, ParameterValues
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.parameters import RESTORE, STORE
from fieldrig_devices.canopen.variable import Variable


class Command(IntEnum):
    """Values of the command object, 2100h."""

    RUN = 1
    STOP = 2
    RESET = 3  # Ctrl-F2
    SAVE = 4


class Control(IntFlag):
    """Bits of the control byte, 2101h, in the order of execution: stop and run together restart the program."""

    STOP = 0x02
    RESET = 0x04
    RUN = 0x01


ORDERED: Final = ((Control.STOP, Command.STOP), (Control.RESET, Command.RESET), (Control.RUN, Command.RUN))
INCLUDING_CARD: Final = (1, 4)
"""Sub-indices of 1010h and 1011h that include the card's parameters."""


def connect(dictionary: Dictionary, card: CardAccess) -> None:
    """Connect the dictionary's objects to the commands of `card`."""
    command = dictionary.find(objects.COMMAND, 0)
    command.writer = lambda data: _do(card, Command(data[0]))
    control = dictionary.find(objects.CONTROL, 0)
    control.writer = lambda data: _on_control(card, control, data)
    for subindex in INCLUDING_CARD:
        _include_card(dictionary.find(STORE, subindex), card, _in_ram)
        _include_card(dictionary.find(RESTORE, subindex), card, _defaults)


def _do(card: CardAccess, command: Command) -> None:
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


def _on_control(card: CardAccess, control: Variable, data: bytes) -> None:
    rising = data[0] & ~control.number
    control.set(data)  # a refused command counts as seen too: it is not carried out later
    for bit, command in ORDERED:
        if rising & bit:
            _do(card, command)


def _include_card(entry: Variable, card: CardAccess, values: Callable[[CardAccess], ParameterValues]) -> None:
    """Save the card's parameters together with the node's: all or none.  The node checks the signature and writes."""
    first = entry.writer
    assert first is not None, "the node stores parameters"

    def write(data: bytes) -> None:
        with card.saving(values(card)):
            first(data)

    entry.writer = write


def _in_ram(card: CardAccess) -> ParameterValues:
    return _different_from_flash(card, lambda group, number: card.parameters.ram[group][number])


def _defaults(card: CardAccess) -> ParameterValues:
    """Defaults that differ from flash.  By CiA 301 they apply from the next start; until then RAM is unchanged."""
    return _different_from_flash(card, lambda group, number: PARAMETERS[group][number].default)


def _different_from_flash(card: CardAccess, value: Callable[[int, int], int]) -> ParameterValues:
    flash = card.parameters.flash
    wanted = {(group, number): value(group, number) for group, table in enumerate(PARAMETERS) for number in table}
    return {(group, number): raw for (group, number), raw in wanted.items() if flash[group][number] != raw}
