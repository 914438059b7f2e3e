"""The card's side of its USER port: answers what a PC asks, in every state, and tells what happens.

Source: manual 4.0 (the serial link is always active), 5.2; digest chapters 10, 17, 20.  WinAxis' protocol is not
published, so this one is ours: docs/arp-user-port.md.
"""

from typing import Annotated

from pydantic import Field

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_devices.arp.outside import Outside


class UserPortSettings(Settings):
    baud: Annotated[int, Field(ge=300, le=10_000_000, description="bits a second that the card sends with")] = 9600


class UserPort:
    """Put together by the card when it has a line: `start` at power-on, `tick` once in every control loop."""

    def __init__(
        self, clock: Clock, line: Link[SerialMessage], card: Outside, settings: UserPortSettings | None = None
    ) -> None:
        self._clock, self._line, self._card = clock, line, card
        self._settings = settings or UserPortSettings()

    def start(self) -> None:
        """Say the format to the line."""

    def tick(self) -> None:
        """Once in every control loop, after the program's slice: the trace, events, whether the PC has gone."""
