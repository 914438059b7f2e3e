"""The node as a CiA 401 module: frames on the bus against terminals, keyboard and motor."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from smart_io_bench import SmartIoBench
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.system.exits import Exit
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.pamring.frames import LedItem
from fieldrig_devices.smart_io.faces.objects import EDS, eds_text

RIG = Path(__file__).parents[4] / "configs" / "smart-io.yaml"
START = CanFrame(0x000, b"\x01\x05")
MOTOR = {"increase": 201, "decrease": 202, "zero": 102, "counter": 101, "braking": 2}


@pytest.fixture
def bench() -> SmartIoBench:
    bench = SmartIoBench(can_slave={"node_id": 5}, motors=[MOTOR])
    bench.can.deliver(START)
    bench.run(1)
    bench.can.take()
    return bench


def frames(bench: SmartIoBench, identifier: int) -> list[str]:
    return [frame.data.hex(" ") for frame in bench.can.take() if frame.identifier == identifier]


def test_the_file_is_the_one_that_the_tables_give() -> None:
    assert EDS.read_text() == eds_text()


def test_inputs_send_the_first_tpdo_when_they_change_and_outputs_follow_the_first_rpdo(bench: SmartIoBench) -> None:
    bench.can.deliver(CanFrame(0x205, bytes.fromhex("10 00 00 08 00 00 00 00")))
    assert (bench.last("valve"), bench.get("out212")) == (True, True)
    bench.wire("button", True)
    bench.wire("limit", True)
    bench.run(1)
    assert frames(bench, 0x185)[-1] == "04 00 80 00 00 00 00 00"
    bench.run(1_000)
    assert bench.can.take() == [], "nothing while nothing changes"


def test_keys_leds_analog_output_and_display_have_pdos(bench: SmartIoBench) -> None:
    bench.wire("start", True)
    bench.run(1)
    assert frames(bench, 0x385) == ["00 08 00 00"]
    bench.can.deliver(CanFrame(0x405, bytes.fromhex("20 00 00 00")))
    bench.can.deliver(CanFrame(0x305, bytes.fromhex("c4 09 48 01")))
    assert (bench.get("led6"), bench.last("speed")) == (True, 2.5)
    assert (bench.get("display"), bench.get("display.blink")) == ("H", True)


def test_a_master_moves_the_motor(bench: SmartIoBench) -> None:
    bench.can.deliver(CanFrame(0x505, bytes.fromhex("0a 00 00 00 01")))  # 10, absolute move
    assert bench.last("motor.inc") is True
    bench.pulse(10)
    bench.run(101)
    assert frames(bench, 0x485)[-1] == "0a 00 00 00 01"
    assert bench.sdo("40 10 20 04 00 00 00 00") == "43 10 20 04 0a 00 00 00"


def test_a_short_circuit_is_an_emergency(bench: SmartIoBench) -> None:
    bench.device.add_fault({"what": "short_circuit", "address": 105})
    bench.can.deliver(CanFrame(0x205, bytes.fromhex("10 00 00 00 00 00 00 00")))
    assert frames(bench, 0x085) == ["20 23 03 02 00 01 00 00"]
    bench.device.clear_fault(1)
    assert frames(bench, 0x085) == ["00 00 00 00 00 00 00 00"]


def test_a_stuck_motor_is_an_emergency_of_its_own(bench: SmartIoBench) -> None:
    bench.can.deliver(CanFrame(0x505, bytes.fromhex("0a 00 00 00 01")))
    bench.run(500)
    assert frames(bench, 0x085) == ["07 ff 81 01 00 00 00 00"]


def test_outputs_take_their_error_values_when_the_node_is_stopped(bench: SmartIoBench) -> None:
    bench.can.deliver(CanFrame(0x205, bytes.fromhex("10 00 00 00 00 00 00 00")))
    bench.can.deliver(CanFrame(0x000, b"\x02\x05"))
    assert bench.last("valve") is False


@pytest.mark.long
def test_a_pam_has_the_outputs_and_the_bus_still_reads(bench: SmartIoBench) -> None:
    bench.configure(LedItem(7, 6))
    bench.can.deliver(CanFrame(0x205, bytes.fromhex("10 00 00 00 00 00 00 00")))
    assert bench.get("out105") is False
    bench.wire("button", True)
    bench.run(1)
    assert frames(bench, 0x185)[-1] == "04 00 00 00 00 00 00 00"


def test_points_may_be_named_in_the_settings() -> None:
    settings: dict[str, Any] = {"node_id": 5, "points": {"6200:01.0": "led6"}}
    bench = SmartIoBench(can_slave=settings)
    bench.can.deliver(START)
    bench.can.deliver(CanFrame(0x205, bytes.fromhex("01 00 00 00 00 00 00 00")))
    assert (bench.get("led6"), bench.get("out101")) == (True, False)


@pytest.mark.long
def test_the_node_passes_the_conformance_suite() -> None:
    arguments: list[Any] = [
        "conform",
        "--rig",
        RIG,
        "--set",
        "time=virtual",
        "--bus",
        "can4",
        "--node",
        31,
        "--eds",
        EDS,
    ]
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert done.exit_code == Exit.OK, done.output


@pytest.mark.long
@settings(max_examples=20)
@given(st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=8)), max_size=10))
def test_any_frames_leave_the_node_at_work(received: list[tuple[int, bytes]]) -> None:
    bench = SmartIoBench(can_slave={"node_id": 5}, motors=[MOTOR])
    for identifier, data in [(0, b"\x01\x05"), *received]:
        bench.can.deliver(CanFrame(identifier, data))
        bench.run(1)
    bench.can.deliver(CanFrame(0, b"\x81\x05"))
    bench.run(100)
    assert bench.sdo("40 00 10 00 00 00 00 00") == "43 00 10 00 91 01 0b 00"
