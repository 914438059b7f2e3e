"""The whole lab in virtual time: the same bytes however it is run, and the tank's level as physics has it."""

import math
import os
import re
import struct
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
import virtual_lab
from virtual_lab import ANALOG_EVENTS_ON, FULL_SPEED, PUMP_OFF, PUMP_ON, READ_INPUTS, START_ALL, Masters, open_outlet

from fieldrig.cli import points
from fieldrig.cli.app import app
from fieldrig.clock import MS, S
from fieldrig.pytest_plugin import RigMaker
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse

pytestmark = pytest.mark.system

AREA_M2, PUMP_M3_PER_S = 0.25, 0.001  # configs/lab.yaml
OUTLET_K = 0.62 * 0.0002 * math.sqrt(2 * 9.80665)  # Torricelli: m3/s through the open outlet at a level of 1 m


@pytest.fixture(scope="module")
def once() -> bytes:
    return virtual_lab.trace()


def elsewhere(*overrides: str, hash_seed: str) -> bytes:
    """The trace of another interpreter, in which sets and dicts of text have another order of hashes."""
    done = subprocess.run(
        [sys.executable, str(Path(virtual_lab.__file__)), *overrides],
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        capture_output=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout


def test_points_that_the_help_of_the_command_line_names_are_there(fieldrig_rig: RigMaker) -> None:
    words = " ".join(filter(None, (app.info.help, points.get.__doc__, points.set_.__doc__)))
    named = set(re.findall(r"\b(tank|io|drive)/([\w.:]+)", words))
    rig = fieldrig_rig("configs/lab.yaml")
    assert len(named) >= 4
    assert [f"{device}/{key}" for device, key in named if key not in rig.keys(device)] == []


def test_trace_has_every_bus(once: bytes) -> None:
    by_bus: dict[str, int] = {}
    for line in once.decode().splitlines():
        bus = line.split()[1]
        by_bus[bus] = by_bus.get(bus, 0) + 1
    assert by_bus.keys() == {"can0", "mb_tcp", "mb_rtu", "wires"}
    assert min(by_bus.values()) > 50


def test_two_runs_give_the_same_bytes(once: bytes) -> None:
    assert virtual_lab.trace() == once


def test_a_process_for_each_device_gives_the_same_bytes(once: bytes) -> None:
    assert virtual_lab.trace(["processes=each"]) == once


@pytest.mark.parametrize("processes", ["one", "each"])
def test_the_order_of_hashes_changes_nothing(once: bytes, processes: str) -> None:
    for hash_seed in ("0", "4711"):
        assert elsewhere(f"processes={processes}", hash_seed=hash_seed) == once


def masters_after(rig: Rig, command: ModbusRequest) -> Masters:
    """Start all nodes with their analogue events, send the command, and run for a second."""
    masters = Masters(rig)
    masters.can.send(START_ALL)
    masters.can.send(ANALOG_EVENTS_ON)
    masters.tcp.send(command)
    rig.run_until(1 * S)
    return masters


def filled_m(seconds: float) -> float:
    """Return the level after filling from 0.5 m with the outlet closed."""
    return 0.5 + PUMP_M3_PER_S / AREA_M2 * seconds


def drained_m(start_m: float, seconds: float) -> float:
    """Through the open outlet with the pump off, by Torricelli's law."""
    return max(0.0, math.sqrt(start_m) - OUTLET_K / (2 * AREA_M2) * seconds) ** 2


def analog_pdos(masters: Masters, since_ns: int) -> list[tuple[float, float]]:
    """Seconds and metres of the second TPDO of the I/O node, 0.1 mm a digit."""
    return [
        ((time_ns - since_ns) / S, int.from_bytes(message.data[:2], "little") * 1e-4)
        for time_ns, message in masters.heard
        if isinstance(message, CanFrame) and message.identifier == 0x285 and time_ns > since_ns
    ]


@pytest.fixture
def rig(fieldrig_rig: RigMaker) -> Rig:
    return fieldrig_rig(virtual_lab.LAB)


def test_modbus_client_starts_the_pump_and_the_level_rises_as_calculated_up_to_the_tpdos(rig: Rig) -> None:
    masters = masters_after(rig, FULL_SPEED)
    masters.tcp.send(PUMP_ON)
    rig.run_until(101 * S)
    assert rig.get("tank", "level") == pytest.approx(filled_m(100), abs=1e-9)
    pdos = analog_pdos(masters, 1 * S)
    assert len(pdos) > 300  # for each millimetre, and a bit: 10 ms of the tank's step
    for seconds, level_m in pdos:
        assert level_m == pytest.approx(filled_m(seconds), abs=2e-4)
    assert all(first < second for first, second in pairwise(pdos))
    masters.tcp.send(READ_INPUTS)
    rig.run_until(101 * S + 10 * MS)
    (answer,) = (message.pdu for _, message in masters.heard[-5:] if isinstance(message, ModbusResponse))
    function, size, level_mm, speed = struct.unpack(">BBHH", answer)
    assert (function, size, speed) == (4, 4, 1000)
    assert level_mm == pytest.approx(900, abs=1)


def test_outlet_opened_by_the_canopen_master_drains_it_as_calculated(rig: Rig) -> None:
    masters = masters_after(rig, PUMP_OFF)
    masters.can.send(open_outlet(100))
    rig.run_until(1 * S + 10 * MS)
    assert rig.get("tank", "outlet") == 100
    rig.run_until(200 * S)
    pdos = analog_pdos(masters, 1 * S)
    assert len(pdos) > 200
    for seconds, level_m in pdos:
        assert level_m == pytest.approx(drained_m(0.5, seconds), abs=2e-4)
    assert rig.get("tank", "level") == pytest.approx(drained_m(0.5, 199), abs=2e-4)
    rig.run_until(1000 * S)
    assert rig.get("tank", "level") == 0
    assert rig.get("io", "6000:01") == 0b10  # the low switch
