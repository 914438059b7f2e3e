"""`kill -9` of a process of the lab while a foreign master works with it."""

import os
import signal
from collections.abc import Callable

import pytest
from lab_masters import (
    BOOT_UP,
    IO,
    SENSOR,
    CanopenMaster,
    Heard,
    Pump,
    canopen_master,
    modbus_rtu,
    modbus_tcp,
    socketcand,
)
from lab_process import LabProcess
from pymodbus.client.base import ModbusBaseSyncClient
from pymodbus.exceptions import ModbusException
from running_rig import until

pytestmark = pytest.mark.real

LEVEL_LIMIT = 2


def kill(lab: LabProcess, process: str) -> Callable[[], None]:
    """Kill it now; what comes back waits until it has been started again."""
    restarts = lab.restarts(process)
    os.kill(lab.pids()[process], signal.SIGKILL)
    return lambda: lab.until_back(process, restarts + 1)


def limit_mm(client: ModbusBaseSyncClient) -> int | None:
    """One poll of the level limit; None if it went wrong."""
    try:
        answer = client.read_holding_registers(LEVEL_LIMIT, count=1, device_id=1)
    except (ModbusException, OSError):
        return None
    return None if answer.isError() else answer.registers[0]


@pytest.mark.parametrize("connect", [modbus_tcp, modbus_rtu])
def test_polling_modbus_master_misses_the_drive_for_a_moment_and_finds_its_memory_again(
    lab: LabProcess, connect: Callable[..., ModbusBaseSyncClient]
) -> None:
    polled: list[int | None] = []
    with connect(lab, timeout_s=0.5) as client:

        def until_polled(wanted: int | None) -> None:
            def poll() -> bool:
                polled.append(limit_mm(client))
                return polled[-1] == wanted

            until(poll)

        until_polled(1800)
        assert not client.write_register(LEVEL_LIMIT, 1234, device_id=1).isError()
        back = kill(lab, "drive")  # at once: what was answered is kept
        until_polled(None)
        until_polled(1234)
        back()
        until_polled(1234)
    assert set(polled) == {1800, None, 1234}


def test_what_is_not_retained_is_as_after_power_on_and_the_pump_stops(lab: LabProcess, pump: Pump) -> None:
    pump.run(50)
    until(lambda: lab.get("tank/inflow") == pytest.approx(0.0005))
    kill(lab, "drive")()
    until(lambda: lab.get("tank/inflow") == 0)
    lab.until_true(lambda: lab.get("drive/speed_set") == 0)


def test_killed_canopen_node_boots_again_and_its_outlet_is_closed(lab: LabProcess, master: CanopenMaster) -> None:
    beats = master.listen(0x700 + IO)
    master.start(master.io)
    master.io.sdo[0x6411][1].raw = 10_000
    until(lambda: lab.get("tank/outlet") == 100)
    beats.clear()
    back = kill(lab, "io")
    until(lambda: BOOT_UP in data(beats))
    back()
    assert data(beats).count(BOOT_UP) == 1
    assert master.io.sdo[0x6411][1].raw == 0
    until(lambda: lab.get("tank/outlet") == 0)
    master.start(master.io)
    assert master.sensor.sdo[0x1000].raw == 0x00020194  # has not been disturbed


def test_pdo_of_a_node_reaches_others_after_its_restart(lab: LabProcess, master: CanopenMaster) -> None:
    kill(lab, "sensor")()
    pdos = master.listen(0x186)
    master.start(master.sensor)
    until(lambda: bool(pdos))
    assert int.from_bytes(pdos[0].data[:4], "little") == 500  # the wire sent the present level to the new process


def until_on_the_bus(master: CanopenMaster) -> None:
    """Both nodes have found the hub again, by themselves."""
    beats = [master.listen(0x700 + node) for node in (IO, SENSOR)]
    until(lambda: all(beats))


def test_when_the_hub_of_the_buses_is_killed_everything_finds_together_again(lab: LabProcess, pump: Pump) -> None:
    kill(lab, "can0")()
    with canopen_master(socketcand(lab)) as master:
        until_on_the_bus(master)
        assert master.io.sdo[0x1008].raw == "IO32"
        before_mm = pump.level_mm
        pump.run(100)
        until(lambda: master.io.sdo[0x6401][1].raw > 10 * before_mm + 20)


def test_wires_keep_their_values_when_their_hub_and_then_a_listener_are_killed(lab: LabProcess, pump: Pump) -> None:
    pump.run(100)
    kill(lab, "can0")()
    with canopen_master(socketcand(lab)) as master:
        until_on_the_bus(master)
    kill(lab, "tank")()
    until(lambda: lab.get("tank/inflow") == pytest.approx(0.001))


def data(heard: list[Heard]) -> list[bytes]:
    return [frame.data for frame in heard]
