"""The outside end of a serial line: its settings in a rig file, and the user of its bytes."""

from collections.abc import Callable, Hashable
from typing import Any, Protocol, Self

from pydantic import Field, model_validator

from fieldrig.bus import Hub
from fieldrig.link import Link
from fieldrig.settings import Address, RunPath
from fieldrig_bus.modbus.faults import LineFault
from fieldrig_bus.modbus.kind import FAULTS, CharacterSettings
from fieldrig_bus.modbus.outside import ServerAddress, UnitId
from fieldrig_bus.modbus.routing import SERVER
from fieldrig_bus.net import HubSettings


class Session(Protocol):
    """The user of the bytes of a line."""

    def on_bytes(self, data: bytes) -> None: ...

    def close(self) -> None: ...

    @property
    def ahead(self) -> int:
        """How many messages were read ahead of the line's time."""


MakeSession = Callable[[Hub, Link[Any], Callable[[bytes], None]], Session]


class ModbusLineSettings(HubSettings, CharacterSettings):
    pty: RunPath | None = Field(
        default=None, description="name of a pty in the run folder, which a master opens as its port"
    )
    port: str | None = Field(default=None, description="a real port, such as /dev/ttyUSB0")
    listen: Address | None = Field(
        default=None, description="host:port where clients connect for the line's bytes over TCP"
    )
    baud: int = Field(default=19200, ge=300, le=10_000_000)
    dial: ServerAddress | None = Field(
        default=None, description="host:port of a serial server to connect to, which has the line"
    )
    max_connections: int = Field(default=8, ge=1, description="masters at `listen`")
    servers: list[UnitId] = Field(
        default_factory=list,
        description="units at the outside end that devices of the rig use; left out: the outside end is a master",
    )
    response_timeout_ms: int = Field(
        default=1000, ge=1, le=600_000, description="response timeout for `servers` (V1.02, 2.4.1)"
    )
    turnaround_ms: int = Field(default=100, ge=0, le=10_000, description="silence after a broadcast to them")
    faults: list[LineFault] = Field(default_factory=list, description=FAULTS)

    def leads_to(self, what: str, value: Hashable) -> bool:
        return value in self.servers

    @model_validator(mode="after")
    def _check_one_way_in(self) -> Self:
        if sum(way is not None for way in (self.pty, self.port, self.listen, self.dial)) != 1:
            raise ValueError("expected exactly one of pty, port, listen and dial")
        if self.servers and self.listen is not None:
            raise ValueError("listen is for masters: expected dial, port or pty beside servers")
        if twice := sorted({unit for unit in self.servers if self.servers.count(unit) > 1}):
            raise ValueError(f"servers: {', '.join(map(str, twice))}: expected each unit once")
        return self

    def member(self, name: str) -> str:
        """The name of the outside end on the bus."""
        return SERVER + name if self.servers else name
