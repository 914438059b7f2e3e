"""`modbus.rtu` and `modbus.ascii`: a serial line with an outside master."""

import os
import time
import tty
from pathlib import Path

import pytest
from modbus_bench import Master, Wire, ascii_, ascii_bus, real_bench, rtu, rtu_bus
from pydantic import ValidationError

from fieldrig.errors import BusError
from fieldrig_bus.modbus.line import ModbusAsciiSettings, ModbusRtu, ModbusRtuSettings

pytestmark = pytest.mark.system

READ = "03 006B 0003"
ANSWER = "03 06 022B 0000 0064"


def test_a_wrong_crc_is_silence_and_a_communication_error() -> None:
    with real_bench(rtu_bus()) as bench:
        wire = bench.open_pty()
        master = Master(wire, rtu)
        wire.write(rtu(1, bytes.fromhex(READ))[:-1] + b"\x00")
        bench.be_quiet()
        master.exchange("08 000C 0000", "08 000C 0001")
        master.exchange("08 000B 0000", "08 000B 0002")
        master.exchange(READ, ANSWER)


def test_a_frame_in_pieces_is_silence_when_strict() -> None:
    with real_bench(rtu_bus()) as bench:
        wire = bench.open_pty()
        frame = rtu(1, bytes.fromhex("06 0001 0003"))
        wire.write(frame[:3])
        bench.be_quiet()
        wire.write(frame[3:])
        bench.be_quiet()
        Master(wire, rtu).exchange("03 0001 0001", "03 02 0000")
        Master(wire, rtu).exchange("08 000C 0000", "08 000C 0002")


def test_two_requests_without_a_silence_are_one_damaged_frame_when_strict() -> None:
    with real_bench(rtu_bus()) as bench:
        wire = bench.open_pty()
        wire.write(2 * rtu(1, bytes.fromhex("06 0001 0003")))
        bench.be_quiet()
        Master(wire, rtu).exchange("03 0001 0001", "03 02 0000")
        Master(wire, rtu).exchange("08 000C 0000", "08 000C 0001")


def test_two_requests_without_a_silence_are_both_answered_when_tolerant() -> None:
    with real_bench(rtu_bus(gaps="tolerant", frame_timeout_ms=60_000)) as bench:
        wire = bench.open_pty()
        wire.write(2 * rtu(1, bytes.fromhex("06 0001 0003")))
        Master(wire, rtu).expect("06 0001 0003")
        Master(wire, rtu).expect("06 0001 0003")


def test_a_frame_timeout_beside_strict_gaps_is_refused() -> None:
    assert rtu_bus(gaps="tolerant", frame_timeout_ms=200).settings.frame_timeout_ms == 200
    with pytest.raises(ValidationError, match="expected gaps: tolerant"):
        rtu_bus(frame_timeout_ms=200)


def test_a_frame_in_pieces_is_heard_when_tolerant() -> None:
    with real_bench(rtu_bus(gaps="tolerant", frame_timeout_ms=60_000)) as bench:
        wire = bench.open_pty()
        frame = rtu(1, bytes.fromhex(READ))
        wire.write(frame[:3])
        bench.be_quiet()
        wire.write(frame[3:])
        Master(wire, rtu).expect(ANSWER)


def test_an_exchange_takes_the_time_of_its_characters() -> None:
    with real_bench(rtu_bus(baud=9600)) as bench:
        wire = bench.open_pty()
        Master(wire, rtu).exchange(READ, ANSWER)
        begin_ns = time.monotonic_ns()
        Master(wire, rtu).exchange(READ, ANSWER)
        bits = 11 * (8 + 3.5 + 11)  # the request, a silence, the response
        assert time.monotonic_ns() - begin_ns >= bits / 9600 * 1e9


def test_another_delimiter_holds_from_the_next_message_on() -> None:
    with real_bench(ascii_bus()) as bench:
        wire = bench.open_pty()
        Master(wire, ascii_).exchange("08 0003 2100", "08 0003 2100")
        wire.write(ascii_(1, bytes.fromhex(READ)).replace(b"\n", b"!"))
        wanted = ascii_(1, bytes.fromhex(ANSWER)).replace(b"\n", b"!")
        assert wire.read(len(wanted)) == wanted


def test_a_real_port_is_opened_with_its_settings(tmp_path: Path) -> None:
    ours, theirs = os.openpty()
    try:
        tty.setraw(theirs)
        port = os.ttyname(theirs)
        with real_bench(ModbusRtu("mb", ModbusRtuSettings(port=port, baud=38400, parity="N"))) as bench:
            wire = Wire(bench, ours, lambda: None)
            Master(wire, rtu).exchange(READ, ANSWER)
            wire.close()
    finally:
        os.close(ours)
        os.close(theirs)


def test_a_port_that_vanishes_does_not_harm_the_rest() -> None:
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    port = os.ttyname(theirs)
    with real_bench(ModbusRtu("mb", ModbusRtuSettings(port=port, baud=38400, parity="N"))) as bench:
        os.close(theirs)
        os.close(ours)
        bench.be_quiet()


def test_a_port_that_is_not_there_is_refused_with_a_remedy() -> None:
    with (
        pytest.raises(BusError, match="dialout"),
        real_bench(ModbusRtu("mb", ModbusRtuSettings(port="/dev/no-such-port"))),
    ):
        pass


def test_a_line_is_in_exactly_one_place() -> None:
    for wrong in ({}, {"pty": "a", "port": "/dev/ttyS0"}, {"listen": "127.0.0.1"}, {"pty": "a", "data_bits": 7}):
        with pytest.raises(ValidationError):
            ModbusRtuSettings.model_validate(wrong)
    assert ModbusAsciiSettings(pty="a").data_bits == 7


def test_a_master_outside_reaches_the_line(tmp_path: Path) -> None:
    assert rtu_bus(baud=19200).ways_in(tmp_path) == [("Modbus RTU", f"{tmp_path}/line")]
    assert rtu_bus(baud=19200).mbpoll() == (("-m", "rtu", "-b", "19200", "-P", "none", "-s", "1"), "{run}/line")
    assert ascii_bus().ways_in(tmp_path) == [("Modbus ASCII", f"{tmp_path}/line")]
    assert ascii_bus().mbpoll() is None  # it knows RTU and TCP only
    for bus, words in ((rtu_bus(baud=19200), "FramerType.RTU, baudrate=19200"), (ascii_bus(), "FramerType.ASCII")):
        steps = bus.pymodbus()
        assert steps is not None
        assert words in steps
        assert "bytesize=8" in steps  # a pty refuses 7
