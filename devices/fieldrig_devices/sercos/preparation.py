"""The preparation of a drive in CP2, as a script that yields requests and is sent the answers."""

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.command import Command
from fieldrig_devices.sercos.idn import Element
from fieldrig_devices.sercos.ring_drive import Drive
from fieldrig_devices.sercos.telegram import CONFIGURED

NO_IDN: Final = 0xFFFF
"""An IDN that no drive has; requesting it ends the phase-up."""


@dataclass(frozen=True, slots=True)
class Ask:
    idn: int
    element: Element = Element.DATA
    data: bytes | None = None
    """Data to write, or None to read."""


Script = Generator[Ask, bytes, None]


def preparation(drive: Drive, timing: Callable[[dict[int, int]], dict[int, int]]) -> Script:
    """Read the drive's own times, write all times and telegrams, and run S-0-0127.  `timing` is `RingPlan.timing`."""
    own: dict[int, int] = {}
    for idn in (
        std.SHORTEST_AT_START,
        std.TRANSMIT_RECEIVE_TIME,
        std.SHORTEST_FEEDBACK_TIME,
        std.TRANSMIT_TRANSMIT_TIME,
        std.RECEIVE_RECEIVE_TIME,
        std.COMMAND_TRANSMIT_TIME,
    ):
        own[idn] = int.from_bytes((yield Ask(idn)), "little")
    for idn, value in timing(own).items():
        yield Ask(idn, data=value.to_bytes(2, "little"))
    yield Ask(std.TELEGRAM_TYPE, data=CONFIGURED.to_bytes(2, "little"))
    for idn, idns in ((std.MDT_CONFIGURATION, drive.mdt), (std.AT_CONFIGURATION, drive.at)):
        yield Ask(idn, data=b"".join(number.to_bytes(2, "little") for number in idns))
    yield from transition(std.CP3_TRANSITION_CHECK)


def transition(idn: int) -> Script:
    """Run the check before the next phase."""
    yield Ask(idn, data=b"\x03\0")
    while True:
        status = int.from_bytes((yield Ask(idn, Element.IDN)), "little") & 0xF
        if status == Command.DONE:
            break
        if status != Command.ACTIVE:
            yield Ask(idn, data=b"\0\0")
            yield Ask(NO_IDN)
    yield Ask(idn, data=b"\0\0")
