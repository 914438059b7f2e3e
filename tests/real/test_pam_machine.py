"""The labelling machine of configs/pam-machine.yaml with foreign masters: pymodbus starts it, snap7 sees it stop."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import pytest
from pam_ways import DataBlock, Registers
from patience import PATIENCE_S
from pymodbus.client import ModbusTcpClient
from ring_process import CONFIGS
from running_rig import AskedRig

from fieldrig.testing import free_port
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.ports import PortVariable, ports_of
from fieldrig_devices.pam.ports.masters.script import carry_out
from fieldrig_devices.pam.ports.masters.vme import VmeMaster

snap7 = pytest.importorskip("snap7", reason="python-snap7 is not installed: pip install python-snap7")

pytestmark = [pytest.mark.real, pytest.mark.timeout(400)]

APPLICATION = CONFIGS / "programs/labeller.pam"
AXES = ("belt", "cutter", "paper")
IDLE, RUNNING = 2, 3
OUTPUT_HEAD = 5 + 1
PANEL = 22
"""Places of words in a VME DualPort: HEAD of the output FIFO, and the fatal error panel (bytes 12 and 44)."""


class Master:
    """A VME master on pymodbus."""

    def __init__(self, port: int) -> None:
        client: Any = ModbusTcpClient("127.0.0.1", port=port, timeout=60)
        assert client.connect()
        self._client, self._words = client, Registers(client)
        self.script = VmeMaster(variables())

    def start_up(self) -> None:
        carry_out(self.script.start_up(), self._words, time.sleep)

    def put(self, name: str, value: bool | int) -> None:
        assert carry_out(self.script.put(name, value), self._words, time.sleep)

    def value(self, name: str) -> Any:
        """Serve the watchdog, read what has changed, and return a value."""
        assert carry_out(self.script.watch(), self._words, time.sleep), "the PAM is dead"
        carry_out(self.script.take(), self._words, time.sleep)
        return self.script.values[name][0]

    def until(self, condition: Callable[[], bool]) -> None:
        give_up_s = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < give_up_s, dict(self.script.values)
            time.sleep(0.01)  # the period in which a master serves the watchdog

    def close(self) -> None:
        self._client.close()


class Machine(NamedTuple):
    rig: AskedRig
    master: Master
    block: DataBlock


def variables() -> tuple[PortVariable, ...]:
    program, _ = checked(APPLICATION.read_text(encoding="utf-8"), APPLICATION.name)
    return ports_of(program)[0].variables


@pytest.fixture(scope="module")
def machine() -> Iterator[Machine]:
    modbus, s7 = free_port(), free_port()
    sets = (
        "devices.plc=null",
        f"buses.dualport.listen=127.0.0.1:{modbus}",
        f"buses.pam_lan.listen={{s7: '127.0.0.1:{s7}', dualport: '127.0.0.1:{free_port()}'}}",
    )
    with AskedRig(CONFIGS / "pam-machine.yaml", None, *(word for key in sets for word in ("--set", key))) as rig:
        rig.until_ready()
        master = Master(modbus)
        client = snap7.client.Client()
        client.connect("127.0.0.1", 0, 2, s7)
        yield Machine(rig, master, DataBlock(client, 1, "big"))
        client.disconnect()
        master.close()
        assert rig.end(signal.SIGINT) == 0, rig.output()


@pytest.fixture(scope="module")
def running(machine: Machine) -> Machine:
    """Started by pymodbus, as a PLC does it."""
    master = machine.master
    master.start_up()
    assert not master.script.mistakes
    master.until(lambda: master.value("DOW_State") == IDLE)
    master.put("DIF_Start", True)
    master.until(lambda: master.value("DOW_State") == RUNNING)
    return machine


@pytest.mark.manual("PAMS-063", "PAMS-074", "PAMS-075")
def test_pymodbus_starts_the_machine_and_counts_its_products(running: Machine) -> None:
    master = running.master
    master.until(lambda: master.value("DOL_Products") >= 2)
    master.until(lambda: master.value("DOF_Running"))
    assert not master.value("DOF_Error")
    assert running.rig.get("pam/DOL_Products") >= 2
    assert running.rig.get("pam/state") == "running"


def test_snap7_sees_the_output_fifo_advance_and_an_empty_panel_while_it_runs(running: Machine) -> None:
    master, block = running.master, running.block
    (before,) = block.read(OUTPUT_HEAD, 1)
    products = master.value("DOL_Products")
    master.until(lambda: master.value("DOL_Products") > products)
    assert block.read(OUTPUT_HEAD, 1) != [before]
    assert block.read(PANEL, 7) == [0] * 7


@pytest.mark.manual("PAMS-056", "PAMS-057")
def test_snap7_finds_why_the_pam_has_stopped_when_the_ring_breaks_while_it_moves(running: Machine) -> None:
    rig, master, block = running
    master.until(lambda: master.value("DOF_Running") and abs(float(rig.get("belt/speed"))) > 1.0)
    done = rig.tool("fault", "pamring", "break", "after=cutter")
    assert done.returncode == 0, done.stderr
    master.until(lambda: block.read(PANEL, 2) == [0x06, 0x010])
    assert block.read(PANEL + 2, 1) != [0]  # the date
    assert (rig.get("pam/state"), rig.get("pam/display")) == ("fatal", "0680F010")
    master.until(lambda: all(rig.get(f"{axis}/speed") == 0.0 for axis in AXES))


def test_a_killed_node_is_fatal_for_the_pam_and_after_a_reset_the_machine_finds_its_zero_again(
    running: Machine,
) -> None:
    rig, master, _ = running
    assert rig.tool("fault", "pamring", "--clear", "all").returncode == 0
    start_again(running)
    os.kill(rig.pid("belt"), signal.SIGKILL)
    master.until(lambda: rig.get("pam/state") == "fatal")
    assert rig.get("pam/display") == "0680F010"
    rig.until_back("belt")
    assert "belt died: killed by SIGKILL" in rig.output()
    start_again(running)


def start_again(machine: Machine) -> None:
    machine.rig.set("pam/reset", True)
    machine.master.start_up()
    machine.master.until(lambda: machine.master.value("DOW_State") == IDLE)
