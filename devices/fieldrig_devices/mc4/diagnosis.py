"""The messages of a drive: codes, texts, classes, and the reactions to them.

Source: manual 4163-4196 (DiagCode, DiagMsg), 4317-4337 (logged codes); digest 1.5 and 3.2.  A code is the class and
three digits; 1117, 2106, 3117 and 7134 are the manual's, with its texts.  117 has two meanings there (digest X4),
so the table uses whole codes.  2108, 1108, 1105, 2112 and 3125 have the base numbers of the successor product;
numbers from 190 on are ours.

Class 1 is error reaction A, 2 and 3 are B, the rest is none (digest 3, an inference): `REACTIONS`.  An overload is
stopped in its own way (manual 10.5).
"""

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, Literal

from fieldrig_devices.mc4.enable import Limit, Reaction

log = logging.getLogger(__name__)

Language = Literal["de", "en"]

REACTIONS: Final[Mapping[int, Reaction]] = {1: Reaction.A, 2: Reaction.B, 3: Reaction.B}
"""Reaction by class; the other classes have none."""


class Code(IntEnum):
    ENCODER_SIGNAL = 1105
    OVERVOLTAGE = 1108
    ENCODER_MEMORY = 1117
    DC_BUS_CONTROLLER = 2106
    RING = 2112
    STOP_TIME_LIMIT = 2190
    OVERLOAD_STOP_TIME = 2191
    UNDERVOLTAGE = 2194
    MAINS_PHASE = 2195
    MOTOR_TEMPERATURE = 3117
    OVERLOAD = 3125
    AMPLIFIER_TEMPERATURE = 3193
    FOLLOWING_ERROR = 3196
    SUPPLY_24V = 7134


@dataclass(frozen=True, slots=True)
class Message:
    de: str
    en: str
    class_1_bit: int
    """Bit in S-0-0011 (IEC 61491); 15 if the message is in S-0-0129 only."""
    reaction: Reaction | None = None
    """The reaction, or None if its class determines it."""


MESSAGES: Final[Mapping[Code, Message]] = {
    Code.ENCODER_SIGNAL: Message("Gebersignal fehlt", "encoder signal missing", 5),
    Code.OVERVOLTAGE: Message("ZK-Überspannung", "DC circuit overvoltage", 8),
    Code.ENCODER_MEMORY: Message("Lesefehler Geber-EEPROM", "encoder EEPROM read error", 5),
    Code.DC_BUS_CONTROLLER: Message(
        "Kommunikationsfehler ZK-Controller", "communication error DC circuit controller", 15
    ),
    Code.RING: Message("SERCOS-Ring gestört", "SERCOS ring failed", 12),
    Code.STOP_TIME_LIMIT: Message("Stoppzeitlimit überschritten", Limit.STOP_TIME.value, 15),
    Code.OVERLOAD_STOP_TIME: Message("Bremszeit überschritten", Limit.OVERLOAD_STOP_TIME.value, 15),
    Code.UNDERVOLTAGE: Message("ZK-Unterspannung", "DC circuit undervoltage", 9),
    Code.MAINS_PHASE: Message("Netzphase fehlt", "mains phase missing", 10),
    Code.MOTOR_TEMPERATURE: Message("Motortemperatur zu hoch", "motor temperature too high", 2),
    Code.OVERLOAD: Message("Überlast", "overload", 0, Reaction.OVERLOAD),
    Code.AMPLIFIER_TEMPERATURE: Message("Endstufentemperatur zu hoch", "amplifier temperature too high", 1),
    Code.FOLLOWING_ERROR: Message("Schleppfehler zu groß", "following error too large", 11),
    Code.SUPPLY_24V: Message("Externe 24V-Versorgung zu niedrig", "external 24 V supply too low", 4),
}
LIMITS: Final = {Limit.STOP_TIME: Code.STOP_TIME_LIMIT, Limit.OVERLOAD_STOP_TIME: Code.OVERLOAD_STOP_TIME}


class Diagnosis:
    """The pending messages.  DiagCode is the most severe, and the first among equal classes.

    Only an acknowledgement removes a message, and only once its cause has gone.
    """

    def __init__(
        self, on_error: Callable[[Reaction], None], classes: Mapping[int, int] | None = None, language: Language = "en"
    ) -> None:
        """`classes` gives the classes that differ from the first digit of the code."""
        self._on_error = on_error
        self._classes = {code: (classes or {}).get(code, code // 1000) for code in Code}
        self.language = language
        self._hidden: list[Code] = []
        """New messages that have not become the DiagCode, because another one is pending (PD-093)."""
        self._pending: dict[Code, bool] = {}
        """Pending codes in the order of their occurrence; True while the cause persists."""

    def raise_(self, code: Code, *, stays: bool = False) -> None:
        """Add a message; with `stays`, its cause persists until `end`."""
        was_pending = code in self._pending
        self._pending[code] = stays or self._pending.get(code, False)
        if not was_pending:
            log.info("diagnosis %d", code)
            if self.code != code:
                self._hidden.append(code)
            self._on_error(self.reaction_to(code))

    def end(self, code: Code) -> None:
        """End the cause of a message; the message stays until it is acknowledged."""
        if code in self._pending:
            self._pending[code] = False

    def class_of(self, code: Code) -> int:
        return self._classes[code]

    def reaction_to(self, code: Code) -> Reaction:
        own = MESSAGES[code].reaction
        return own if own is not None else REACTIONS.get(self._classes[code], Reaction.NONE)

    def quit(self) -> bool:
        """Remove the messages without a cause; True if none is left that the drive reacts to."""
        for code in [code for code, is_there in self._pending.items() if not is_there]:
            del self._pending[code]
        if self.has_error:
            return False
        self._hidden.clear()
        return True

    def tell_next(self) -> bool:
        """End the time for which a hidden message is in `number`.  Return true if there was one."""
        return bool(self._hidden and self._hidden.pop(0))

    @property
    def has_error(self) -> bool:
        """True if a message is pending that the drive reacts to."""
        return bool(self._errors)

    @property
    def _errors(self) -> list[Code]:
        return [code for code in self._pending if self.reaction_to(code) is not Reaction.NONE]

    @property
    def pending(self) -> tuple[Code, ...]:
        return tuple(self._pending)

    @property
    def code(self) -> int:
        """DiagCode; 0 if no message is pending."""
        return min(self._pending, key=lambda code: self._classes[code], default=0)

    @property
    def number(self) -> int:
        """S-0-0390: the DiagCode; for some cycles a hidden message instead, so that the controller's log has all."""
        return int(self._hidden[0] if self._hidden else self.code)

    @property
    def text(self) -> str:
        """DiagMsg of the axis."""
        code = self.code
        return self.text_of(Code(code)) if code else ""

    def text_of(self, code: Code) -> str:
        return MESSAGES[code].de if self.language == "de" else MESSAGES[code].en

    @property
    def class_1(self) -> int:
        """S-0-0011, the errors that shut the drive down."""
        word = 0
        for code in self._errors:
            word |= 1 << MESSAGES[code].class_1_bit
        return word

    @property
    def manufacturer_class_1(self) -> int:
        """S-0-0129: one bit for each message without a bit of its own in S-0-0011."""
        return sum(bit for code, bit in MANUFACTURER_BITS.items() if code in self._errors)


MANUFACTURER_BITS: Final = {
    code: 1 << bit for bit, code in enumerate(code for code, message in MESSAGES.items() if message.class_1_bit == 15)
}
