"""`telephone.exchange`: the telephone network in real time, with calls from and to programs outside the rig."""

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Self

from pydantic import Field, model_validator

from fieldrig.bus import Port, Time
from fieldrig.device import Tool, WayIn
from fieldrig.outside.addresses import split_address
from fieldrig.settings import Address, Settings
from fieldrig_bus.net import HubSettings
from fieldrig_bus.telephone.bus import Number, TelephoneBus, TelephoneSettings, check_apart
from fieldrig_bus.telephone.ports import IncomingPort, OutgoingPort


class IncomingSettings(Settings):
    """A TCP port from which programs call a number."""

    listen: Address = Field(description="host:port at which programs connect")
    number: Number = Field(description="number that each connection calls")
    telnet: bool = Field(default=False, description="true: Telnet, as its clients speak it; false: raw bytes")


class OutgoingSettings(Settings):
    """A number that leads to a program."""

    number: Number
    dial: Address = Field(description="host:port to which a call to the number connects")
    telnet: bool = Field(default=False, description="true: Telnet; false: raw bytes")


class TelephoneExchangeSettings(HubSettings, TelephoneSettings):
    incoming: list[IncomingSettings] = Field(default=[], description="TCP ports for calls from outside")
    outgoing: list[OutgoingSettings] = Field(default=[], description="phone book of programs that can be called")

    def outside_lines(self) -> Sequence[str]:
        return [member_of(entry) for entry in self.outgoing]

    @model_validator(mode="after")
    def _check_phone_book(self) -> Self:
        entries = [*self.numbers.items(), *((member_of(entry), entry.number) for entry in self.outgoing)]
        check_apart(entries)
        known = [number for _, number in entries]
        for index, entry in enumerate(self.incoming):
            if entry.number not in known:
                expected = ", ".join(known) or "numbers for members first"
                raise ValueError(f"incoming.{index}.number: {entry.number} leads nowhere: expected {expected}")
        return self


def member_of(entry: OutgoingSettings) -> str:
    """Return the name under which a program of the phone book is a member of the network."""
    return f"outside {entry.number}"


class TelephoneExchange(TelephoneBus):
    about: ClassVar[str] = "a telephone network for modems, with calls over TCP"
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})
    settings: TelephoneExchangeSettings

    def __init__(self, name: str, settings: TelephoneExchangeSettings) -> None:
        super().__init__(name, settings)

    def numbers(self) -> dict[str, str]:
        return super().numbers() | {member_of(entry): entry.number for entry in self.settings.outgoing}

    def ports(self) -> Sequence[Port]:
        settings = self.settings
        return (
            *(OutgoingPort(member_of(entry), entry.dial, entry.telnet) for entry in settings.outgoing),
            *(IncomingPort(entry.listen, entry.number, entry.telnet) for entry in settings.incoming),
        )

    def ways_in(self, run: Path) -> list[WayIn]:
        return [WayIn(f"telephone {entry.number}", entry.listen) for entry in self.settings.incoming]

    def tools(self, run: Path) -> list[Tool]:
        return [Tool(f"call {entry.number}", _line_to(entry)) for entry in self.settings.incoming]


def _line_to(entry: IncomingSettings) -> str:
    host, port = split_address(entry.listen)
    return f"telnet {host} {port}" if entry.telnet else f"python -m serial.tools.miniterm socket://{host}:{port}"
