"""How programs outside join a CAN bus whose medium is our model: by the socketcand protocol, and as a Lawicel adapter.

In virtual time they are the addresses at which members of a block of `virtual_time` connect.
"""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from pydantic import Field, model_validator

from fieldrig.bus import Port
from fieldrig.device import Tool, WayIn
from fieldrig.outside.addresses import split_address
from fieldrig.settings import Address, RunPath, Settings
from fieldrig_bus.can.model_bus import CanModelBus, CanSettings

# The Lawicel commands S0 to S8 by bit rate, as option -s of slcand takes them.
LAWICEL_SPEED = {
    10_000: 0,
    20_000: 1,
    50_000: 2,
    100_000: 3,
    125_000: 4,
    250_000: 5,
    500_000: 6,
    800_000: 7,
    1_000_000: 8,
}


class SlcanSettings(Settings):
    """Settings of the Lawicel ASCII protocol."""

    path: RunPath | None = Field(default=None, description="a pty's link, relative to the run folder")
    listen: Address | None = Field(default=None, description="host:port")

    @model_validator(mode="after")
    def _check_there_is_a_way_in(self) -> Self:
        if self.path is None and self.listen is None:
            raise ValueError("expected a path (a pty), listen (host:port), or both")
        return self


class OutsidersSettings(CanSettings):
    socketcand: Address | None = Field(default=None, description="host:port for the socketcand protocol (python-can)")
    channel: str | None = Field(
        default=None,
        pattern=r"^[^\s<>]+$",
        description="name of the bus for clients of socketcand, without blanks; left out: the name in the rig file",
    )
    slcan: SlcanSettings | None = Field(default=None, description="the Lawicel ASCII protocol (slcand, python-can)")


class OutsidersBus(CanModelBus):
    """A CAN bus that programs outside can join."""

    settings: OutsidersSettings

    def __init__(self, name: str, settings: Any) -> None:
        super().__init__(name, settings)
        self._channel = settings.channel or name

    def ports(self) -> Sequence[Port]:
        settings, ports = self.settings, list[Port]()
        if settings.socketcand is not None:
            from fieldrig_bus.can.socketcand import SocketcandPort  # only the process of the hub needs it

            ports.append(SocketcandPort(settings.socketcand, self._channel))
        if settings.slcan is not None:
            from fieldrig_bus.can.lawicel import LawicelPort

            ports.append(LawicelPort(self.name, settings.slcan.path, settings.slcan.listen))
        return ports

    def python_can(self) -> dict[str, object] | None:
        """Arguments for socketcand, otherwise for Lawicel over TCP.  `tools` has the path of a pty."""
        if self.settings.socketcand is not None:
            host, port = _reachable(self.settings.socketcand)
            return {"interface": "socketcand", "channel": self._channel, "host": host, "port": port}
        if self.settings.slcan is not None and self.settings.slcan.listen is not None:
            host, port = _reachable(self.settings.slcan.listen)
            return {"interface": "slcan", "channel": f"socket://{host}:{port}"}
        return None

    def ways_in(self, run: Path) -> list[WayIn]:
        settings = self.settings
        ways = [] if settings.socketcand is None else [WayIn("socketcand", settings.socketcand)]
        if settings.slcan is not None:
            places = (settings.slcan.path and str(run / settings.slcan.path), settings.slcan.listen)
            ways += [WayIn("Lawicel (slcan)", place) for place in places if place]
        return ways

    def tools(self, run: Path) -> list[Tool]:
        settings, tools = self.settings, list[Tool]()
        if settings.socketcand is not None:
            host, port = _reachable(settings.socketcand)
            line = f"-i socketcand -c {shlex.quote(self._channel)} --bus-kwargs host={host} port={port}"
            tools.append(Tool("watch", f"python -m can.viewer {line}"))
            tools.append(Tool("log", f"python -m can.logger {line}"))
        if settings.slcan is not None and settings.slcan.path is not None:
            pty = shlex.quote(str(run / settings.slcan.path))
            tools.append(Tool("log by slcan", f"python -m can.logger -i slcan -c {pty}"))
            speed = "" if settings.bitrate not in LAWICEL_SPEED else f" -s{LAWICEL_SPEED[settings.bitrate]}"
            device = f"sudo slcand -o -c{speed} $(readlink -f {pty}) slcan0 && sudo ip link set slcan0 up"
            tools.append(Tool("network device", device))
        if settings.slcan is not None and settings.slcan.listen is not None:
            host, port = _reachable(settings.slcan.listen)
            tools.append(Tool("log by slcan", f"python -m can.logger -i slcan -c socket://{host}:{port}"))
        return tools


def _reachable(address: str) -> tuple[str, int]:
    """Host and port by which a client on this machine reaches a listening address."""
    host, port = split_address(address)
    return {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host), port
