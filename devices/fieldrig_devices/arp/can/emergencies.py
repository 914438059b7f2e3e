"""The card's errors as emergency messages.

Source: digest chapter 20, CiA 301 table 26.  Warnings are not sent.  The manufacturer-specific bytes contain the code
of the card (103 to 116, two bytes), its axis, and its state.
"""

import struct
from typing import Final, NamedTuple

from fieldrig_devices.arp import card_errors
from fieldrig_devices.arp.card_access import CardAccess
from fieldrig_devices.canopen.emcy import COMMUNICATION
from fieldrig_devices.canopen.node import CanopenNode

MANUFACTURER = 0x80
"""Bits of the error register, apart from the generic one."""
INFO: Final = struct.Struct("<HBB")


class Meaning(NamedTuple):
    code: int
    register: int = 0


MEANINGS: Final = {
    card_errors.EEPROM: Meaning(0x5530),  # hardware: EEPROM
    card_errors.RESET: Meaning(0x9000),  # external: Enable is low
    card_errors.CAN: Meaning(0x8130, COMMUNICATION),  # a node that the card monitors is lost; or see BUS_OFF
    card_errors.STOPPED_PROGRAM: Meaning(0x6200, MANUFACTURER),  # user software
    card_errors.STACK: Meaning(0x6100, MANUFACTURER),  # internal software
    card_errors.PARAMETERS: Meaning(0x6320, MANUFACTURER),  # parameter error
    card_errors.CONTROL_LOSS: Meaning(0x8611, MANUFACTURER),  # following error
}


BUS_OFF: Final = Meaning(0x8140, COMMUNICATION)
"""The CAN error of a card that was bus-off, sent after its recovery."""


class Emergencies:
    """Sends an error when `refresh` first finds it, and clears all errors once the card has none."""

    def __init__(self, node: CanopenNode, card: CardAccess) -> None:
        self._node, self._card = node, card
        self._present: dict[int, tuple[Meaning, bytes]] = {}
        """Errors that have been sent, by the card's code."""
        self._times_off = 0

    def refresh(self) -> None:
        error, times_off = self._card.errors.error, self._node.bus_errors.times_off
        if error == 0:
            self._clear()
        elif error in MEANINGS and error not in self._present:
            was_off = error == card_errors.CAN and times_off > self._times_off
            info = INFO.pack(error, self._card.errors.error_axis, self._card.state)
            self._present[error] = BUS_OFF if was_off else MEANINGS[error], info
        self._times_off = times_off
        for meaning, info in self._present.values():
            self._node.emcy.raise_error(meaning.code, meaning.register, info)  # has no effect unless the node was reset

    def _clear(self) -> None:
        for meaning, _ in self._present.values():
            self._node.emcy.clear_error(meaning.code)
        self._present.clear()
