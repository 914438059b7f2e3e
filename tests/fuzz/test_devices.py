"""Corrupted messages to a device or a pty: no device ends, and later requests are answered."""

import asyncio
import os
import random
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from arp_bench import CardBench
from arp_terminal import TerminalBench
from canopen_bench import CanopenBench
from hiperface_bench import EncoderBench, telegram
from modem_bench import ModemBench
from single_drive_bench import SingleDriveBench
from spoiling import spoilt
from strangers import hub_of

from fieldrig_bus.can.frame import EXTENDED_MASK, FD_LENGTHS, STANDARD_MASK, CanFrame
from fieldrig_bus.can.socketcan_wire import CLASSICAL, FD, from_wire, notice_from_wire, to_wire
from fieldrig_bus.modbus.framing_rtu import rtu_frame
from fieldrig_bus.telephone.message import Carrier, Heard, Offer, Ready, Ring, TelephoneMessage, Tone, check_sent
from fieldrig_bus.telephone.modulation import everything

pytestmark = pytest.mark.system

SEED = 2026
A_CLIENT = 25
"""Inputs of one client of a pty."""

PTYS: dict[str, tuple[str, dict[str, Any], list[bytes]]] = {
    "serial": ("serial.pty", {"path": "PTY", "paced": False}, [b"hello\r\n", bytes(range(256)), b"\x11\x13"]),
    "modbus": ("modbus.rtu", {"listen": None, "pty": "PTY"}, [rtu_frame(1, bytes.fromhex("0300010002"))]),
}


@pytest.mark.share(0.2)
@pytest.mark.parametrize("name", PTYS)
def test_a_pty_goes_on(name: str, tmp_path: Path, inputs_a_target: int) -> None:
    kind, settings, seeds = PTYS[name]
    chance = random.Random(f"{SEED}/pty/{name}")
    path = tmp_path / "PTY"

    async def scene() -> None:
        async with hub_of(kind, tmp_path, **settings) as hub:
            members = set(hub._members)
            for first in range(0, inputs_a_target, A_CLIENT):
                client = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
                for _ in range(first, min(first + A_CLIENT, inputs_a_target)):
                    with suppress(BlockingIOError):  # the kernel's buffer is full: the rest is lost
                        os.write(client, spoilt(chance, seeds))
                    await asyncio.sleep(0)
                with suppress(BlockingIOError):
                    os.read(client, 65536)
                os.close(client)
            assert set(hub._members) == members
            assert path.is_symlink()

    asyncio.run(scene())


def test_a_frame_of_the_kernel_can_be_on_a_bus(inputs_a_target: int) -> None:
    """A program on a vcan fills struct can_frame and canfd_frame as it likes."""
    chance = random.Random(f"{SEED}/socketcan")
    seeds = [
        to_wire(CanFrame(0x123, b"12")),
        to_wire(CanFrame(1, bytes(64), is_fd=True)),
        b"\x04\0\0\x20\x08" + bytes(11),
    ]
    for _ in range(inputs_a_target):
        data = spoilt(chance, seeds)
        size = FD.size if len(data) > CLASSICAL.size else CLASSICAL.size
        data = data[:size].ljust(size, b"\0")
        frame = from_wire(data)
        if frame is None:
            notice_from_wire(data)


def _card() -> tuple[Any, Callable[[], Any], int]:
    bench = CardBench(with_can=True).run_for(50)
    return bench.can, lambda: bench.run_for(1), 10


def _node() -> tuple[Any, Callable[[], Any], int]:
    bench = CanopenBench()
    return bench.can, lambda: bench.after(1), 5


def _drive() -> tuple[Any, Callable[[], Any], int]:
    bench = SingleDriveBench()
    return bench.can, lambda: bench.after(1), 5


def _terminal() -> tuple[Any, Callable[[], Any], int]:
    bench = TerminalBench()
    return bench.can, lambda: bench.after(1), 20


CAN_DEVICES: dict[str, Callable[[], tuple[Any, Callable[[], Any], int]]] = {
    "arp": _card, "canopen.node": _node, "cia402.drive": _drive, "terminal.tr": _terminal
}  # fmt: skip


@pytest.mark.share(0.2)
@pytest.mark.parametrize("kind", CAN_DEVICES)
def test_a_device_on_can_goes_on(kind: str, inputs_a_target: int) -> None:
    """SDO, PDO, NMT, LSS, SYNC, guarding: any frame that a bus can carry."""
    can, pass_time, node_id = CAN_DEVICES[kind]()
    chance = random.Random(f"{SEED}/can/{kind}")
    services = [0, 0x80, 0x100, 0x7E5, *(base + node_id for base in range(0x80, 0x780, 0x80))]
    requests = [bytes.fromhex(text) for text in (
        "4000100000000000", "2b02200001000000", "2100200009000000", "c603200009000000", "a40020007f000000",
        "2310100173617665", "2300180185010040", "0401000000000000", "4000000000000000", "8100", "0100",
        "2b4060000f000000", "2f60600003000000", "23ff600000000080", "237a6000ffffff7f",
    )]  # fmt: skip
    for number in range(inputs_a_target):
        identifier = chance.choice(services) if chance.random() < 0.9 else chance.randrange(EXTENDED_MASK + 1)
        data, is_fd, is_remote = spoilt(chance, requests), chance.random() < 0.02, chance.random() < 0.05
        length = max(item for item in (FD_LENGTHS if is_fd else range(9)) if item <= len(data))
        if is_remote and not is_fd:
            sent = CanFrame(identifier, b"", identifier > STANDARD_MASK, True, length)
        else:
            sent = CanFrame(identifier, data[:length], identifier > STANDARD_MASK, is_fd=is_fd)
        can.deliver(sent)
        if number % 4 == 0:
            pass_time()
            can.take()


@pytest.mark.share(0.2)
def test_an_encoder_goes_on(inputs_a_target: int) -> None:
    chance = random.Random(f"{SEED}/encoder")
    seeds = [telegram(text) for text in ("42", "43 00000000 55", "4a 00 70 01 55", "4b 00 70 01 55 07", "53", "52")]
    bench = EncoderBench()
    for number in range(inputs_a_target):
        bench.send(spoilt(chance, seeds))
        if number % 8 == 0:
            bench.heard(20)
    bench.wait(1000)
    bench.send(telegram("50", bench.encoder.eeprom.address))  # read encoder status
    assert bench.heard()[1:2] in (b"\x50", b"\xd0")  # with the error bit set, if the noise left an error


@pytest.mark.share(0.2)
def test_a_modem_goes_on(inputs_a_target: int) -> None:
    chance = random.Random(f"{SEED}/modem")
    seeds = [b"AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2\r", b"ATDT200,W@;\r", b"AT+MS=V32,0;+IPR=0\r", b"A/", b"+++",
             b"ATH1S7?\r", b"AT&Z1=5&W1&V\r", b"ATA\r", b"ATO\r", b"ATS2=43S12=0\r"]  # fmt: skip
    answers: list[TelephoneMessage] = [
        Heard(Tone.DIAL), Ring(True), Ring(False), Offer(everything(), 1), Carrier(9600, True), Heard(Tone.BUSY),
        Carrier(0), Ready(False), Ready(True), b"data",
    ]  # fmt: skip
    bench = ModemBench()
    for _ in range(inputs_a_target):
        bench.type(spoilt(chance, seeds))
        if chance.random() < 0.5:
            bench.hear(chance.choice(answers))
        if chance.random() < 0.1:
            bench.wait(chance.random() * 3)
            bench.heard()
            for message in bench.said():
                check_sent(message)
    bench.modem.clear_fault(bench.modem.add_fault({"what": "power_off"}))
    again = ModemBench(bench.store)
    end = bytes((again.modem._engine.interpreter.profile.registers[3],))
    again.type(end + b"AT&FE0Q0V1" + end).heard()
    assert again.ask("AT") == "\r\nOK\r\n"
