"""The outside end of a serial line at a real port.  A port that vanishes is reopened when it is back."""

import asyncio
import logging
import os
from collections.abc import Callable
from typing import Any, cast

from serial import serial_for_url
from serial.serialutil import SerialException

from fieldrig.bus import Hub, Port
from fieldrig.errors import BusError
from fieldrig_bus.modbus.dialler import pause_s
from fieldrig_bus.modbus.line_place import MakeSession, ModbusLineSettings, Session
from fieldrig_bus.serial.port_errors import reason

log = logging.getLogger(__name__)


class UartPort(Port):
    def __init__(self, bus: str, settings: ModbusLineSettings, make_session: MakeSession) -> None:
        self._bus, self._settings, self._make_session = bus, settings, make_session
        self._device, self._member = settings.port or "", settings.member("port")
        self._hub: Hub | None = None
        self._serial: Any = None
        self._session: Session | None = None
        self._failures = 0
        self._again: asyncio.TimerHandle | None = None

    async def open(self, hub: Hub) -> None:
        try:
            self._plug_in()
        except (SerialException, ValueError) as cause:
            remedy = "plug it in, name another port, or join the group that may open it (dialout)"
            raise BusError(f"{self._bus}: cannot open {self._device}: {reason(cause)}", remedy) from cause
        self._hub = hub
        self._session = self._make_session(hub, hub.join(self._member), self._write)

    async def close(self) -> None:
        if self._again is not None:
            self._again.cancel()
        if self._serial is not None:
            self._unplug(self._serial)
        if self._hub is not None and self._session is not None:
            self._session.close()
            self._hub.leave(self._member)
        self._hub = None

    def _plug_in(self) -> None:
        """Open the port.  SerialException or ValueError if that fails."""
        settings, open_uart = self._settings, cast(Callable[..., Any], serial_for_url)
        self._serial = open_uart(
            self._device,
            settings.baud,
            settings.data_bits,
            settings.parity,
            settings.stop_bits,
            timeout=0,
            exclusive=True,
        )
        asyncio.get_running_loop().add_reader(self._serial.fileno(), self._on_readable)

    def _plug_in_again(self) -> None:
        try:
            self._plug_in()
        except (SerialException, ValueError) as fault:
            log.debug("%s: %s", self._bus, fault)
            self._wait()
        else:
            self._failures = 0
            log.info("%s: %s is back", self._bus, self._device)

    def _wait(self) -> None:
        self._failures += 1
        self._again = asyncio.get_running_loop().call_later(pause_s(self._failures), self._plug_in_again)

    def _write(self, data: bytes) -> None:
        if self._serial is None:
            return
        try:
            written = os.write(self._serial.fileno(), data)
        except OSError as fault:
            written = 0
            log.debug("%s: %s", self._device, fault)
        if written < len(data):
            log.debug("%s accepts no more data: a frame of %d bytes is lost", self._device, len(data))

    def _on_readable(self) -> None:
        if self._serial is None or self._session is None:
            return
        try:
            data = os.read(self._serial.fileno(), 4096)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if data:
            self._session.on_bytes(data)
        else:
            log.warning("%s: %s has disappeared", self._bus, self._device)
            self._unplug(self._serial)
            self._wait()

    def _unplug(self, uart: Any) -> None:
        asyncio.get_running_loop().remove_reader(uart.fileno())
        uart.close()
        self._serial = None
