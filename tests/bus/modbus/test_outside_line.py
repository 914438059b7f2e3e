"""Servers outside on a serial line whose master is in the rig: Modbus over serial line V1.02, 2.4.1 and 2.5."""

import os
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest
from modbus_bench import ascii_, rtu
from modbus_outside import End, Listener, OutsideBench, listener, open_pty, outside_bench
from pydantic import ValidationError

from fieldrig_bus.modbus import dialler
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.line import ModbusAscii, ModbusAsciiSettings, ModbusRtu, ModbusRtuSettings
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse

pytestmark = pytest.mark.system

BAUD = 115200
READ, ANSWER = "03 006B 0003", "03 06 02 2b 00 00 00 64"
Frame = Callable[[int, bytes], bytes]


def rtu_line(**settings: Any) -> ModbusRtu:
    return ModbusRtu("line", ModbusRtuSettings(**{"baud": BAUD, "servers": [7, 8], **settings}))


def ascii_line(**settings: Any) -> ModbusAscii:
    return ModbusAscii("line", ModbusAsciiSettings(**{"baud": BAUD, "servers": [7, 8], **settings}))


@contextmanager
def by_pty(make: Callable[..., Any], **settings: Any) -> Iterator[tuple[OutsideBench, End]]:
    with outside_bench(make(pty="line", **settings)) as bench:
        yield bench, open_pty(bench, "line")


@contextmanager
def by_port(make: Callable[..., Any], **settings: Any) -> Iterator[tuple[OutsideBench, End]]:
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    try:
        with outside_bench(make(port=os.ttyname(theirs), parity="N", **settings)) as bench:
            yield bench, End(bench, ours, lambda: None)
    finally:
        os.close(ours)
        os.close(theirs)


@contextmanager
def by_dial(make: Callable[..., Any], **settings: Any) -> Iterator[tuple[OutsideBench, End]]:
    with listener() as at, outside_bench(make(dial=at.address, **settings)) as bench:
        yield bench, at.accept(bench)


WAYS = {"pty": by_pty, "port": by_port, "dial": by_dial}
FRAMES: dict[Any, Frame] = {rtu_line: rtu, ascii_line: ascii_}


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dialler, "FIRST_PAUSE_S", 0.01)


@pytest.fixture(params=[(way, make) for way in WAYS for make in FRAMES], ids=lambda way: f"{way[0]} {way[1].__name__}")
def line(request: pytest.FixtureRequest) -> Iterator[tuple[OutsideBench, End, Frame]]:
    way, make = request.param
    extra = {"data_bits": 8} if make is ascii_line and way == "port" else {}  # a pty refuses 7
    with WAYS[way](make, response_timeout_ms=60_000, **extra) as (bench, end):
        yield bench, end, FRAMES[make]


def hear(end: End, frame: Frame, unit: int = 7, pdu: str = READ) -> None:
    wanted = frame(unit, bytes.fromhex(pdu))
    assert end.read(len(wanted)) == wanted


def say_in_vain(bench: OutsideBench, end: End, data: bytes) -> None:
    """Wait until the bytes have been received, and ignored."""
    port = bench.hub._ports[0]
    session = getattr(port, "_intake", port)._session
    before = session.foreign + session._framer.errors
    end.write(data)
    bench.pump(lambda: session.foreign + session._framer.errors > before)


def test_a_device_asks_a_server_on_the_line(line: tuple[OutsideBench, End, Frame]) -> None:
    bench, end, frame = line
    for exchange in (1, 2):
        bench.ask(7, READ)
        hear(end, frame)
        end.write(frame(7, bytes.fromhex(ANSWER)))
        assert bench.expect() == [(7, exchange, ANSWER)]


def test_what_is_broken_foreign_or_no_answer_is_ignored(line: tuple[OutsideBench, End, Frame]) -> None:
    bench, end, frame = line
    bench.ask(7, READ)
    hear(end, frame)
    right = frame(7, bytes.fromhex(ANSWER))
    for wrong in (
        right[:-3] + bytes((right[-3] ^ 1,)) + right[-2:],  # checksum
        frame(8, bytes.fromhex(ANSWER)),  # another server
        frame(7, bytes.fromhex("04 06 022B 0000 0064")),  # another function
        frame(7, bytes.fromhex("03 04 022B 0000")),  # less than was requested
    ):
        say_in_vain(bench, end, wrong)
    assert bench.answers() == []
    end.write(right)
    assert bench.expect() == [(7, 1, ANSWER)]


def test_requests_go_one_at_a_time(line: tuple[OutsideBench, End, Frame]) -> None:
    bench, end, frame = line
    other = bench.hub.join("other")
    heard: list[ModbusResponse] = []
    other.on_receive(heard.append, ())
    bench.ask(7, READ)
    bench.in_loop(lambda: other.send(ModbusRequest(8, bytes.fromhex(READ), 9)))
    hear(end, frame)
    bench.wait_ms(20)
    assert not end.received
    end.write(frame(7, bytes.fromhex(ANSWER)))
    bench.expect()
    hear(end, frame, 8)
    end.write(frame(8, bytes.fromhex("83 02")))
    bench.pump(lambda: bool(heard))
    assert heard == [ModbusResponse(8, bytes.fromhex("83 02"), 9)]


def test_a_silent_server_holds_the_others_up_until_the_response_timeout() -> None:
    with by_pty(rtu_line, response_timeout_ms=100) as (bench, end):
        other = bench.hub.join("other")
        begin_ns = bench.clock.now_ns()
        bench.ask(7, READ)
        bench.in_loop(lambda: other.send(ModbusRequest(8, bytes.fromhex(READ), 9)))
        hear(end, rtu)
        hear(end, rtu, 8)
        assert bench.clock.now_ns() - begin_ns >= 100_000_000
        say_in_vain(bench, end, rtu(7, bytes.fromhex(ANSWER)))  # late: another request has been sent
        assert bench.answers() == []


def test_a_client_that_asks_again_does_not_wait_for_its_previous_request(line: tuple[OutsideBench, End, Frame]) -> None:
    bench, end, frame = line
    bench.ask(7, READ)
    hear(end, frame)
    bench.ask(7, "03 0000 0001")
    hear(end, frame, 7, "03 0000 0001")
    say_in_vain(bench, end, frame(7, bytes.fromhex(ANSWER)))  # the late response, which has a different size
    end.write(frame(7, bytes.fromhex("03 02 0001")))
    assert bench.expect() == [(7, 2, "03 02 00 01")]


def test_a_broadcast_is_not_answered_and_followed_by_the_turnaround_time(line: tuple[OutsideBench, End, Frame]) -> None:
    bench, end, frame = line
    begin_ns = bench.clock.now_ns()
    bench.ask(0, "06 0001 0003")
    bench.ask(7, READ)
    hear(end, frame, 0, "06 0001 0003")
    hear(end, frame)
    assert bench.clock.now_ns() - begin_ns >= 100_000_000
    say_in_vain(bench, end, frame(0, bytes.fromhex("06 0001 0003")))
    end.write(frame(7, bytes.fromhex(ANSWER)))
    assert bench.expect() == [(7, 2, ANSWER)]


def test_what_a_server_says_unasked_is_no_request(line: tuple[OutsideBench, End, Frame]) -> None:
    bench, end, frame = line
    heard: list[Any] = []
    bench.hub.join("device").on_receive(heard.append, [1])
    say_in_vain(bench, end, frame(1, bytes.fromhex(READ)))
    say_in_vain(bench, end, frame(7, bytes.fromhex(ANSWER)))
    assert (heard, bench.answers()) == ([], [])


def test_a_unit_of_the_rig_is_not_asked_outside(line: tuple[OutsideBench, End, Frame]) -> None:
    bench, end, frame = line
    device = bench.hub.join("device")
    device.on_receive(lambda request: device.send(ModbusResponse(7, b"\x83\x02", request.exchange)), [7])
    bench.ask(7, READ)
    assert bench.expect() == [(7, 1, "83 02")]
    bench.ask(8, READ)
    hear(end, frame, 8)
    assert not end.received


def test_a_request_takes_the_time_of_its_characters() -> None:
    with by_pty(rtu_line, baud=9600) as (bench, end):
        begin_ns = bench.clock.now_ns()
        bench.ask(7, READ)
        hear(end, rtu)
        timing = LineTiming(baud=9600)
        assert bench.clock.now_ns() - begin_ns >= timing.frame_ns(5) + timing.silence_ns  # 13 ms


def test_a_server_that_comes_late_hears_nothing_that_was_asked_before_the_last() -> None:
    with outside_bench(rtu_line(pty="line")) as bench:
        for register in (1, 2, 3):
            bench.ask(7, f"03 000{register} 0001")
            bench.wait_ms(5)
        fd = os.open(bench.run / "line", os.O_RDWR | os.O_NOCTTY)  # tty.setraw would discard waiting data
        end = End(bench, fd, lambda: os.close(fd))
        hear(end, rtu, 7, "03 0003 0001")


def test_a_serial_server_that_dies_is_dialled_again() -> None:
    with listener() as at, outside_bench(rtu_line(dial=at.address)) as bench:
        asked_over(bench, at)
        bench.ends.pop().close()
        asked_over(bench, at)


def test_a_serial_server_may_come_later() -> None:
    with listener() as at:
        at.shut()
        with outside_bench(rtu_line(dial=at.address)) as bench:
            bench.ask(7, READ)
            bench.wait_ms(30)
            at.again()
            asked_over(bench, at)


def asked_over(bench: OutsideBench, at: Listener) -> None:
    end = at.accept(bench)
    bench.heard.clear()
    exchange = bench.ask(7, READ)
    hear(end, rtu)
    end.write(rtu(7, bytes.fromhex(ANSWER)))
    assert bench.expect() == [(7, exchange, ANSWER)]


@pytest.mark.parametrize("servers", [[7], []])
def test_a_port_that_vanished_is_opened_again_when_it_is_back(tmp_path: Path, servers: list[int]) -> None:
    port = tmp_path / "tty"
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    port.symlink_to(os.ttyname(theirs))
    with outside_bench(rtu_line(port=str(port), parity="N", servers=servers)) as bench:
        os.close(theirs)
        os.close(ours)
        port.unlink()
        bench.wait_ms(30)
        ours, theirs = os.openpty()
        tty.setraw(theirs)
        port.symlink_to(os.ttyname(theirs))
        end = End(bench, ours, lambda: None)
        uart = bench.hub._ports[0]
        bench.pump(lambda: uart._serial is not None)
        if servers:
            bench.ask(7, READ)
            hear(end, rtu)
            end.write(rtu(7, bytes.fromhex(ANSWER)))
            assert bench.expect() == [(7, 1, ANSWER)]
        else:
            device = bench.hub.join("device")
            device.on_receive(lambda request: device.send(ModbusResponse(1, b"\x83\x02", request.exchange)), [1])
            end.write(rtu(1, bytes.fromhex(READ)))
            assert end.read(5) == rtu(1, b"\x83\x02")
        end.close()
    os.close(theirs)
    os.close(ours)


@pytest.mark.parametrize("make", FRAMES)
def test_a_program_that_writes_more_than_the_line_carries_has_to_wait(make: Callable[..., Any]) -> None:
    """Otherwise the line would be busy for hours with what a program has written in a second, frames or not."""
    with outside_bench(make(pty="line", servers=[], baud=300)) as bench:
        port = os.open(bench.run / "line", os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(port)
        accepted = 0
        for _ in range(1_000):
            with suppress(BlockingIOError):
                accepted += os.write(port, bytes(1_000))
            bench.in_loop(lambda: None)
        os.close(port)
        assert accepted < 500_000  # the buffers of the system, and what is read at once
        assert bench.hub.statistics()["clients that had to wait"] == 1.0


@pytest.mark.parametrize("make", FRAMES)
def test_a_serial_server_that_sends_more_than_the_line_carries_has_to_wait(make: Callable[..., Any]) -> None:
    with listener() as at, outside_bench(make(dial=at.address, servers=[], baud=300)) as bench:
        end = at.accept(bench)
        end.write(bytes(16_384))
        bench.pump(lambda: "clients that had to wait" in bench.hub.statistics())


def test_a_master_behind_a_serial_server_is_answered() -> None:
    with listener() as at, outside_bench(rtu_line(dial=at.address, servers=[])) as bench:
        device = bench.hub.join("device")
        device.on_receive(lambda request: device.send(ModbusResponse(1, b"\x83\x02", request.exchange)), [1])
        end = at.accept(bench)
        end.write(rtu(1, bytes.fromhex(READ)))
        assert end.read(5) == rtu(1, b"\x83\x02")


@pytest.mark.parametrize(
    ("settings", "right"),
    [
        ({"listen": "127.0.0.1:5021"}, "expected dial, port or pty beside servers"),
        ({"pty": "a", "dial": "10.0.0.9:4001"}, "exactly one of pty, port, listen and dial"),
        ({"dial": "10.0.0.9:0"}, "expected HOST:PORT"),
        ({"pty": "a", "servers": [7, 8, 7]}, "each unit once"),
        ({"pty": "a", "servers": [0]}, "greater than or equal to 1"),
        ({"pty": "a", "servers": [248]}, "less than or equal to 247"),
        ({"pty": "a", "response_timeout_ms": 0}, "greater than or equal to 1"),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any], right: str) -> None:
    with pytest.raises(ValidationError, match=right):
        ModbusRtuSettings.model_validate({"servers": [7], **settings})


def test_where_the_master_is_in_the_rig_no_line_for_masters_is_printed(tmp_path: Path) -> None:
    for bus in (
        rtu_line(pty="line"),
        rtu_line(dial="10.0.0.9:4001"),
        ascii_line(pty="line"),
        ascii_line(port="/dev/x"),
    ):
        assert bus.ways_in(tmp_path) == []
        assert bus.pymodbus() is None
        assert bus.mbpoll() is None
