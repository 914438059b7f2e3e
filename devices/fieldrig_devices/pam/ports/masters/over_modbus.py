"""Runs the script of a master over a Modbus link, so that a device of a rig can be the master."""

import struct
from collections.abc import Callable
from typing import Any, Final

from fieldrig.clock import MS, Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.modbus.message import ModbusEvent, ModbusRequest, ModbusResponse
from fieldrig_devices.pam.ports.masters.script import Access, MasterError, Pause, Read, Script, Write

TIMEOUT_NS: Final = 1_000 * MS
"""Time after which a request without a response has failed."""
_HEAD: Final = struct.Struct(">BHH")


class ModbusScript:
    """One script; a request that fails is raised in it as a MasterError."""

    def __init__(
        self, clock: Clock, link: Link[ModbusEvent], unit: int, script: Script[Any], on_end: Callable[[], None]
    ) -> None:
        self._clock, self._link, self._unit, self._script, self._on_end = clock, link, unit, script, on_end
        self._exchange = 0
        self._access: Access | None = None
        self._late = Alarm(clock)

    def begin(self) -> None:
        self._step(())

    def stop(self) -> None:
        self._access = None
        self._late.stop()

    def on_message(self, message: ModbusEvent) -> None:
        access = self._access
        if access is None or not isinstance(message, ModbusResponse) or message.exchange != self._exchange:
            return  # a late response, or another message
        pdu = message.pdu
        if isinstance(access, Read) and pdu[:2] == bytes((3, 2 * access.count)) and len(pdu) == 2 + 2 * access.count:
            self._step(struct.unpack(f">{access.count}H", pdu[2:]))
        elif isinstance(access, Write) and pdu == _HEAD.pack(16, access.word, len(access.values)):
            self._step(())
        else:
            self._fail(f"the PAM has answered {pdu.hex(' ')}")

    def _step(self, words: tuple[int, ...]) -> None:
        self.stop()
        try:
            self._carry_out(self._script.send(words) if words else next(self._script))
        except StopIteration:
            self._on_end()

    def _fail(self, why: str) -> None:
        self.stop()
        try:
            self._carry_out(self._script.throw(MasterError(why)))
        except StopIteration:
            self._on_end()

    def _carry_out(self, access: Access) -> None:
        match access:
            case Pause(duration_ns=duration_ns):
                self._clock.call_at(self._clock.now_ns() + duration_ns, self.begin)
                return
            case Read(word=word, count=count):
                pdu = _HEAD.pack(3, word, count)
            case Write(word=word, values=values):
                data = struct.pack(f">{len(values)}H", *values)
                pdu = _HEAD.pack(16, word, len(values)) + bytes((len(data),)) + data
        self._access = access
        self._exchange = self._exchange + 1 & 0xFFFF
        self._late.after(TIMEOUT_NS, lambda: self._fail("the PAM does not answer"))
        self._link.send(ModbusRequest(self._unit, pdu, self._exchange))
