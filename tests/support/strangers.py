"""Connections to a hub that say whatever a test likes, and every kind of bus that has a hub."""

import asyncio
import logging
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from patience import PATIENCE_S

from fieldrig.bus import Bus, DirectBus, ModelBus
from fieldrig.config import kinds
from fieldrig.hub.hub import LocalHub
from fieldrig.hub.wire import HEADER, Kind, pack
from fieldrig.loop.real_clock import RealClock
from fieldrig.outside.untrusted import read_json

# The settings that a kind needs so that its ports listen at free addresses.
SETTINGS: dict[str, dict[str, Any]] = {
    "can.hub": {"socketcand": "127.0.0.1:0", "slcan": {"listen": "127.0.0.1:0"}},
    "modbus.tcp": {"listen": "127.0.0.1:0"},
    "modbus.rtu": {"listen": "127.0.0.1:0"},
    "modbus.ascii": {"listen": "127.0.0.1:0"},
    "serial.tcp": {"listen": "127.0.0.1:0"},
    "serial.rfc2217": {"listen": "127.0.0.1:0"},
    "can.socketcan": {"channel": "vcan0"},
}


def kind_names() -> list[str]:
    """Return every installed kind of bus."""
    return list(kinds.installed("fieldrig.buses"))


def bus_of(kind: str, **more: Any) -> Bus[Any]:
    cls = kinds.find_bus(kind)
    return cls("bus0", kinds.settings_model(cls).model_validate({**SETTINGS.get(kind, {}), **more}))


def hub_kinds() -> list[str]:
    """Return the kinds with a hub in real time."""
    return [name for name in kind_names() if _has_hub(kinds.find_bus(name))]


def direct_kinds() -> list[str]:
    return [name for name in kind_names() if issubclass(kinds.find_bus(name), DirectBus)]


def _has_hub(cls: type[Bus[Any]]) -> bool:
    return issubclass(cls, ModelBus) and "real" in cls.times


@asynccontextmanager
async def hub_of(kind: str, run: Path, **more: Any) -> AsyncIterator[LocalHub]:
    """A hub that is open, with its ports.  Whatever its loop has to complain of fails the test."""
    loop = asyncio.get_running_loop()
    complaints: list[dict[str, Any]] = []
    loop.set_exception_handler(lambda _loop, context: complaints.append(context))
    bus = bus_of(kind, **more)
    assert isinstance(bus, ModelBus)
    clock = RealClock(loop)
    hub = LocalHub(bus, clock, run)
    await hub.open()
    try:
        yield hub
    finally:
        await hub.close()
        clock.close()
    assert complaints == []


class Stranger:
    """A raw connection to a hub's socket."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader, self._writer = reader, writer

    @classmethod
    async def at(cls, path: Path) -> "Stranger":
        return cls(*await asyncio.open_unix_connection(str(path)))

    @classmethod
    async def at_tcp(cls, port: int) -> "Stranger":
        return cls(*await asyncio.open_connection("127.0.0.1", port))

    def say(self, *records: bytes) -> None:
        self._writer.write(b"".join(records))

    async def heard(self) -> tuple[int, Any]:
        """The next record of the hub: kind, and its JSON."""
        kind, _, length = HEADER.unpack(await self._reader.readexactly(HEADER.size))
        return kind, read_json(await self._reader.readexactly(length))

    async def until_put_off(self) -> str:
        """Why the hub closed this connection; "" if it said nothing."""
        why = ""
        async with asyncio.timeout(PATIENCE_S):
            try:
                while True:
                    kind, said = await self.heard()
                    if kind == Kind.REFUSED:
                        why = said["why"]
            except (asyncio.IncompleteReadError, ConnectionResetError):
                self._writer.close()
                return why

    def close(self) -> None:
        self._writer.close()


def hello(member: str, bus: str = "bus0", **more: str) -> bytes:
    import json

    return pack(Kind.HELLO, 0, json.dumps({"bus": bus, "member": member, **more}).encode())


def warnings_of(records: Iterator[logging.LogRecord]) -> list[str]:
    return [record.getMessage() for record in records if record.levelno >= logging.WARNING]
