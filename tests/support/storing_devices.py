"""Every kind of device that stores, by one value that a client of it can store: what is asked, what is answered.

A power cycle is another device on the same store.
"""

import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any, Final, cast

from arp_bench import CardBench
from arp_terminal import TerminalBench
from canopen_bench import CanopenBench, parse, show
from hiperface_bench import telegram
from hmiscu_device_bench import DeviceBench
from max4_bench import PLATE
from max4_bench import Bench as Max4Bench
from modem_bench import ModemBench
from single_drive_bench import SingleDriveBench
from smart_io_bench import SmartIoBench

from fieldrig.clock import MS, VirtualClock
from fieldrig.errors import ControlError
from fieldrig.storage.store import Store
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_devices.hiperface.device import SmEncoder, SmEncoderSettings
from fieldrig_devices.modbus.device import ModbusDevice, ModbusDeviceSettings

SAVE: Final = "23 10 10 01 73 61 76 65"
SAVED, REFUSED_SDO = "60 10 10 01", "80 10 10 01 00 00 06 06"
TABLE: Final = "holding_registers: [{address: 0, name: one, retained: true, max: 1000}]"


@dataclass(frozen=True)
class Storing:
    """A device that is on."""

    write: Callable[[int], str]
    """Store a value from 1 to 200; what is answered."""
    read: Callable[[], int]
    accepted: str
    refused: str
    """Beginnings of answers."""


def _card(store: Store) -> Storing:
    bench = CardBench(store=store, with_can=True).run_for(50)

    def sdo(request: str) -> str:
        bench.can.take()
        bench.can.deliver(parse(f"60A#{request}"))
        bench.run_for(20)
        frames = [show(frame) for frame in bench.can.take() if isinstance(frame, CanFrame)]
        (answer,) = (frame[4:] for frame in frames if frame.startswith("58A#"))
        return answer

    def write(value: int) -> str:
        assert sdo(f"23 01 23 0B {value:02x} 00 00 00")[:2] == "60"
        answer = sdo(SAVE)
        if answer == REFUSED_SDO:
            assert bench.error == 103  # E03, until Enable is opened and closed
        return answer

    return Storing(write, lambda: bench.access.parameters.flash[1][11], SAVED, REFUSED_SDO)


def _node(store: Store) -> Storing:
    return _by_sdo(CanopenBench(store=store))


def _drive(store: Store) -> Storing:
    return _by_sdo(SingleDriveBench(store))


def _by_sdo(bench: CanopenBench) -> Storing:
    def write(value: int) -> str:
        bench.write(f"2b 17 10 00 {value:02x} 00 00 00")
        return bench.sdo(SAVE)

    return Storing(write, lambda: int(bench.point("1017:00")), SAVED, REFUSED_SDO)


def _panel_controller(store: Store) -> Storing:
    return _slave(DeviceBench(can_slave={"node_id": 5}, store=store))


def _smart_io(store: Store) -> Storing:
    return _slave(SmartIoBench(can_slave={"node_id": 5}, store=store))


def _slave(bench: DeviceBench | SmartIoBench) -> Storing:
    """A device whose points are objects of a slave."""

    def sdo(request: str) -> str:
        bench.can.take()
        bench.can.deliver(parse(f"605#{request}"))
        (answer,) = (show(frame)[4:] for frame in bench.can.take() if show(frame).startswith("585#"))
        return answer

    def write(value: int) -> str:
        assert sdo(f"2b 17 10 00 {value:02x} 00 00 00")[:2] == "60"
        return sdo(SAVE)

    return Storing(write, lambda: int(bench.get("can/1017:00")), SAVED, REFUSED_SDO)


def _terminal(store: Store) -> Storing:
    bench = TerminalBench(store)

    def sdo(request: str) -> str:
        (answer,) = (frame[4:] for frame in bench.send(f"614#{request}") if frame.startswith("594#"))
        return answer

    def write(value: int) -> str:
        assert sdo(f"2b 17 10 00 {value:02x} 00 00 00")[:2] == "60"
        return sdo(SAVE)

    def read() -> int:
        return int.from_bytes(bytes.fromhex(sdo("40 17 10 00 00 00 00 00"))[4:6], "little")

    return Storing(write, read, SAVED, REFUSED_SDO)


def _controller(store: Store) -> Storing:
    bench = Max4Bench(store=cast(Any, store)).run(100)

    def write(value: int) -> str:
        bench.set("MsgFilter", 0xFF00 | value)
        try:
            bench.do("save parameters")
        except ControlError as refused:
            return refused.what
        return "saved"

    refused = "command cannot be 'save parameters': the flash disk cannot be written: No space left on device"
    return Storing(write, lambda: int(bench.get("MsgFilter")) & 0xFF, "saved", refused)


def _registers(store: Store) -> Storing:
    link: RecordedLink[ModbusRequest | ModbusResponse] = RecordedLink()
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "table.yaml"
        table.write_text(TABLE)
        settings = ModbusDeviceSettings(table=table, turnaround_ms=0)
        device = ModbusDevice(VirtualClock(), settings, [link], store)
    device.start()

    def write(value: int) -> str:
        link.deliver(ModbusRequest(1, bytes.fromhex(f"060000{value:04x}")))
        (answer,) = link.take()
        assert isinstance(answer, ModbusResponse)
        return answer.pdu.hex()

    return Storing(write, lambda: int(device.points()["one"].read()), "060000", "8604")


def _encoder(store: Store) -> Storing:
    clock, line = VirtualClock(), RecordedLink[SerialMessage]()
    device = SmEncoder(clock, "x", SmEncoderSettings(name_plate=Path(PLATE)), store, Random(1), line)
    device.start()
    clock.advance_to(200 * MS)

    def ask(request: str) -> bytes:
        line.deliver(telegram(request))
        clock.advance_to(clock.now_ns() + 200 * MS)
        return b"".join(sent for sent in line.take() if isinstance(sent, bytes))[1:-1]

    def read() -> int:
        answer = ask("4a 00 70 01 55")
        return answer[-1] if answer[0] & 0x7F == 0x4A else 0xFF  # a memory that is lost has no data field

    return Storing(lambda value: ask(f"4b 00 70 01 55 {value:02x}").hex(), read, "4b007001", "5005")


def _modem(store: Store) -> Storing:
    bench = ModemBench(store)
    bench.ask("ATE0")

    def read() -> int:
        return int(bench.ask("ATS7?").split()[0])

    return Storing(lambda value: bench.ask(f"ATS7={value}&W").strip(), read, "OK", "ERROR")


KINDS: Final[Mapping[str, Callable[[Store], Storing]]] = {
    "arp": _card,
    "canopen.node": _node,
    "cia402.drive": _drive,
    "hmiscu": _panel_controller,
    "max4": _controller,
    "modbus.device": _registers,
    "modem": _modem,
    "sm.encoder": _encoder,
    "smart_io": _smart_io,
    "terminal.tr": _terminal,
}
"""Functions that build a device of a kind on its store, and switch it on."""


@contextmanager
def disk_test(kind: str, store: Callable[[], Store], fill: Callable[[bool], None]) -> Iterator[None]:
    """The life of a device whose disk is full for a while.  `store` is that of a process that starts."""
    power_on = KINDS[kind]

    def write(device: Storing, value: int, is_accepted: bool) -> None:
        answer, expected = device.write(value), device.accepted if is_accepted else device.refused
        assert answer.startswith(expected), f"{answer!r}, expected {expected!r}"

    device = power_on(store())
    write(device, 1, True)
    fill(True)
    for value in (2, 3):
        write(device, value, False)
    yield
    again = power_on(store())  # also on a disk that is full
    assert again.read() == 1
    write(again, 4, False)
    fill(False)
    write(device, 5, True)
    assert power_on(store()).read() == 5
