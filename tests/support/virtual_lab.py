"""The lab in virtual time with three masters at work, and every byte of it.

python tests/support/virtual_lab.py processes=each     the trace, on standard output
"""

import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, Clock, S
from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest

LAB = Path(__file__).parents[2] / "configs" / "lab.yaml"

START_ALL = CanFrame(0x000, bytes.fromhex("01 00"))
SYNC = CanFrame(0x080)
ANALOG_EVENTS_ON = CanFrame(0x605, bytes.fromhex("2f 23 64 00 01 00 00 00"))  # 6423h := true
READ_LEVEL = CanFrame(0x606, bytes.fromhex("40 30 91 01 00 00 00 00"))  # 9130h sub-index 1
FULL_SPEED = ModbusRequest(1, bytes.fromhex("06 0000 03e8"))
PUMP_ON, PUMP_OFF = ModbusRequest(1, bytes.fromhex("05 0000 ff00")), ModbusRequest(1, bytes.fromhex("05 0000 0000"))
READ_INPUTS = ModbusRequest(1, bytes.fromhex("04 0000 0002"))


def open_outlet(percent: float) -> CanFrame:
    return CanFrame(0x305, round(percent * 100).to_bytes(2, "little") + bytes(6))


class Masters:
    """A PLC on the CAN bus, and one on each Modbus bus."""

    def __init__(self, rig: Rig) -> None:
        plc, scada, panel = rig.attach("plc"), rig.attach("scada"), rig.attach("panel")
        self.can, self.tcp, self.rtu = plc.link("can0"), scada.link("mb_tcp"), panel.link("mb_rtu")
        self.heard: list[tuple[int, Any]] = []
        for node, link in ((plc, self.can), (scada, self.tcp), (panel, self.rtu)):
            link.on_receive(partial(self._on_message, node.clock))

    def _on_message(self, clock: Clock, message: Any) -> None:
        self.heard.append((clock.now_ns(), message))


def play(rig: Rig) -> None:
    """Fifteen seconds in which the tank is filled, then drained, and everybody looks."""
    masters = Masters(rig)
    script: list[tuple[int, Callable[[], None]]] = [
        (1 * MS, lambda: masters.can.send(START_ALL)),
        (5 * MS, lambda: masters.can.send(ANALOG_EVENTS_ON)),
        (1 * S, lambda: masters.tcp.send(FULL_SPEED)),
        (1 * S + 1, lambda: masters.rtu.send(PUMP_ON)),
        (8 * S, lambda: masters.can.send(open_outlet(75))),
        (10 * S, lambda: masters.tcp.send(PUMP_OFF)),
    ]
    script += [(n * 100 * MS, lambda: masters.can.send(SYNC)) for n in range(1, 150)]
    script += [(n * 130 * MS, lambda: masters.can.send(READ_LEVEL)) for n in range(1, 110)]
    script += [(n * 90 * MS, lambda: masters.tcp.send(READ_INPUTS)) for n in range(1, 160)]
    script += [(n * 70 * MS, lambda: masters.rtu.send(READ_INPUTS)) for n in range(1, 200)]
    for when_ns, act in sorted(script, key=lambda step: step[0]):
        rig.run_until(when_ns)
        act()
    rig.run_until(15 * S)


def trace(overrides: Sequence[str] = ()) -> bytes:
    """Return every message on every bus: time, bus, sender, bytes, receivers."""
    lines: list[str] = []

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        data = bus.encode(delivery.message).hex()
        lines.append(f"{delivery.time_ns} {bus.name} {delivery.sender} {data} {','.join(delivery.receivers)}\n")

    with Rig(load(LAB, [*overrides, "time=virtual"]), on_delivery) as rig:
        play(rig)
    return "".join(lines).encode()


if __name__ == "__main__":
    sys.stdout.buffer.write(trace(sys.argv[1:]))
