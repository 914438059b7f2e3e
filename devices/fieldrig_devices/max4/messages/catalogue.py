"""The messages of the controller: codes, texts, filter classes.

Source: PacDrive manual 3246-3261, 4093-4110, 4163-4196, 4317-4337 (the catalogue of digest 1.5), in the words of the
manual, with English texts beside them.  117 has two meanings there (digest X4), so the keys of the table are whole
codes, whose first digit is the default class.  Our own numbers, where the manual has none: 190 for the division error
and up to 198 for other faults of programs, 560 and up for the ring, 570 and up for field buses, 574 for logins; 507 is
the base number of the successor.  505 and 506 are reserved (digest X3).  The codes of drives are in `mc4.diagnosis`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from fieldrig_devices.mc4.diagnosis import MESSAGES as DRIVE_MESSAGES

GENERAL: Final = 0x0001
DIAGNOSIS: Final = 0x0002
FIELD_BUS: Final = 0x0008
EXTENDED: Final = 0x1000
"""Filter classes: 0x0001, 0x0002 and 0x1000 are in the logs of the manual; their names are those of digest 3."""


class Code(IntEnum):
    """Codes with their default class."""

    SERIOUS_CYCLE_ERROR = 4313
    DIVISION_ERROR = 4190
    ARRAY_BOUNDS = 4191
    VALUE_RANGE = 4192
    POINTER = 4193
    STACK = 4194
    STRING = 4195
    FUNCTION = 4196
    PROGRAM = 4197
    CYCLE_ERROR = 6317
    WRITE_OVERFLOW = 6507
    RING_OPEN = 2560
    AT_FAILED = 2561
    DRIVE_MISSING = 2562
    DRIVE_REFUSED = 2563
    NO_ROOM = 2564
    VERSION = 2565
    CONFIGURATION = 2566
    RAM_LOST = 7567
    FIELD_BUS_LOST = 6570
    BOOT_STARTED = 8002
    BOOT_FINISHED = 8003
    PROGRAM_STARTED = 8004
    AUTOSTART = 8005
    LOGIN = 8007
    LOGOUT = 8008
    FILE_WRITTEN = 8010
    TCP_CONNECTED = 8013
    SYSTEM_RESET = 8016
    RING_UP = 8568
    FIELD_BUS_BACK = 8571
    EMERGENCY = 8572
    LOGIN_REFUSED = 8574
    PROGRAM_REFUSED = 8198


@dataclass(frozen=True, slots=True)
class Message:
    """The text of a code in both languages, with its filter class."""

    de: str
    en: str
    type: int = DIAGNOSIS
    is_quittable: bool = True


MESSAGES: Final[Mapping[int, Message]] = {
    **{int(code): Message(message.de, message.en) for code, message in DRIVE_MESSAGES.items()},
    Code.SERIOUS_CYCLE_ERROR: Message(
        "Schwere Zykluszeitüberschreitung", "serious cycle time transgression", is_quittable=False
    ),
    Code.CYCLE_ERROR: Message("Zykluszeitüberschreitung", "cycle time transgression"),
    Code.DIVISION_ERROR: Message("Divisionsfehler", "Division error"),
    Code.ARRAY_BOUNDS: Message("Feldgrenzen überschritten", "array bounds exceeded"),
    Code.VALUE_RANGE: Message("Wert außerhalb des Unterbereichs", "value outside its subrange"),
    Code.POINTER: Message("Ungültiger Zeiger", "invalid pointer"),
    Code.STACK: Message("Stapelüberlauf", "stack overflow"),
    Code.STRING: Message("Fehler bei Zeichenkette", "string error"),
    Code.FUNCTION: Message("Fehler in einer Systemfunktion", "error in a system function"),
    Code.PROGRAM: Message("IEC-Programm nicht ladbar", "IEC program cannot be loaded"),
    Code.WRITE_OVERFLOW: Message("Schreibzyklus-Überlauf", "write cycle overflow"),
    Code.RING_OPEN: Message("SERCOS-Ring offen", "SERCOS ring is open"),
    Code.AT_FAILED: Message("Antriebstelegramm fehlt", "drive telegram missing"),
    Code.DRIVE_MISSING: Message("Antrieb antwortet nicht", "drive does not answer"),
    Code.DRIVE_REFUSED: Message("Antrieb lehnt Hochlauf ab", "drive refuses the phase-up"),
    Code.NO_ROOM: Message("Zykluszeit zu kurz für alle Antriebe", "cycle time is too short for all drives"),
    Code.VERSION: Message("Version nicht verträglich", "version is not compatible"),
    Code.CONFIGURATION: Message("Steuerungskonfiguration fehlerhaft", "control configuration is faulty"),
    Code.RAM_LOST: Message("Gepufferter Speicher verloren", "buffered memory was lost"),
    Code.BOOT_STARTED: Message("Max4-Boot gestartet", "Max4 boot started", GENERAL),
    Code.BOOT_FINISHED: Message("Max4-Boot beendet", "Max4 boot finished", GENERAL),
    Code.PROGRAM_STARTED: Message("IEC-Programm gestartet", "IEC program started", GENERAL),
    Code.AUTOSTART: Message("Automatischer Programmstart aktiv", "automatic program start active", GENERAL),
    Code.LOGIN: Message("EPAS-4 Login", "EPAS-4 Login", GENERAL),
    Code.LOGOUT: Message("EPAS-4 Logout", "EPAS-4 Logout", GENERAL),
    Code.FILE_WRITTEN: Message("Datei schreiben", "file written", EXTENDED),
    Code.TCP_CONNECTED: Message("connect zum TCP/IP Server", "connect to TCP/IP server", EXTENDED),
    Code.SYSTEM_RESET: Message("System Reset", "System Reset", EXTENDED),
    Code.RING_UP: Message("SERCOS-Ring in Betrieb", "SERCOS ring is in operation", EXTENDED),
    Code.PROGRAM_REFUSED: Message("IEC-Programm abgewiesen", "IEC program refused", EXTENDED),
    Code.FIELD_BUS_LOST: Message("Feldbus-Teilnehmer fehlt", "field bus node is missing", FIELD_BUS),
    Code.FIELD_BUS_BACK: Message("Feldbus-Teilnehmer wieder da", "field bus node is back", FIELD_BUS),
    Code.LOGIN_REFUSED: Message("Anmeldung mehrfach abgewiesen", "login refused several times", GENERAL),
    Code.EMERGENCY: Message("Feldbus-Teilnehmer meldet Fehler", "field bus node reports an error", FIELD_BUS),
}


def message_of(code: int) -> Message:
    """The message of a code, or of a code with the same three digits if the class has been changed."""
    if code in MESSAGES:
        return MESSAGES[code]
    alike = (message for other, message in MESSAGES.items() if other % 1000 == code % 1000)
    return next(alike, Message(f"Diagnose {code}", f"diagnosis {code}"))


def translated(text: str, code: int, language: str) -> str:
    """Return a text that ends with the message of a code, with that message in `de` or `en`; any other as it is."""
    message = message_of(code)
    wanted = {"de": message.de, "en": message.en}.get(language)
    for known in (message.de, message.en):
        if wanted is not None and text.endswith(known):
            return text.removesuffix(known) + wanted
    return text
