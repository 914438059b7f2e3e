"""What the master asks and tells each drive in CP2, as a script: it yields what to ask for, and gets the answers."""

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.command import Command
from fieldrig_devices.sercos.idn import Element
from fieldrig_devices.sercos.ring_drive import Drive
from fieldrig_devices.sercos.telegram import CONFIGURED

NO_IDN: Final = 0xFFFF
"""Asked for to end the way up: no drive has it, so that it is refused."""


@dataclass(frozen=True, slots=True)
class Ask:
    idn: int
    element: Element = Element.DATA
    data: bytes | None = None
    """To be written; None: read."""


Script = Generator[Ask, bytes, None]


def preparation(drive: Drive, timing: Callable[[dict[int, int]], dict[int, int]]) -> Script:
    """Its own times are read, then all times, its telegrams and S-0-0127; `timing` is `RingPlan.timing` for it."""
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
        yield Ask(idn, data=b"".join(one.to_bytes(2, "little") for one in idns))
    yield from transition(std.CP3_TRANSITION_CHECK)


def transition(idn: int) -> Script:
    """The check that lets the ring into the next phase."""
    yield Ask(idn, data=b"\x03\0")
    while True:
        status = int.from_bytes((yield Ask(idn, Element.IDN)), "little") & 0xF
        if status == Command.DONE:
            break
        if status != Command.ACTIVE:
            yield Ask(idn, data=b"\0\0")
            yield Ask(NO_IDN)
    yield Ask(idn, data=b"\0\0")
