"""pymodbus, a Modbus client that is not ours, is the VME master of a PAM: start-up to RUN, and variables both ways."""

import time
from collections.abc import Iterator
from textwrap import indent
from typing import Any

import pytest
from pam_port_kinds import KINDS
from pam_ports import GROUP, VME
from pam_programs import HEADER
from pam_ways import Registers
from pymodbus.client import ModbusTcpClient
from running_rig import AskedRig, until

from fieldrig.testing import free_port
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.ports import ports_of
from fieldrig_devices.pam.ports.masters.script import carry_out
from fieldrig_devices.pam.ports.masters.vme import VmeMaster

pytestmark = pytest.mark.real

PROGRAM = (
    HEADER
    + GROUP
    + VME.replace("MASTER_READY_TIMEOUT = 500", "MASTER_READY_TIMEOUT = NONE").replace(
        "MASTER_INACTIVITY_TIMEOUT = 500", "MASTER_INACTIVITY_TIMEOUT = NONE"
    )
)
RIG = """
time: real
buses:
  plc: {{kind: modbus.tcp, listen: "127.0.0.1:{port}"}}
devices:
  pam:
    kind: "pam_port_kinds:PortHost"
    links: {{modbus: [plc]}}
    program: |
{program}
"""


@pytest.fixture(scope="module")
def rig() -> Iterator[tuple[AskedRig, int]]:
    port = free_port()
    with AskedRig(RIG.format(port=port, program=indent(PROGRAM, " " * 6)), KINDS) as rig:
        rig.until_ready()
        yield rig, port


@pytest.mark.manual("PAMS-063", "PAMS-067", "PAMS-069", "PAMS-070", "PAMS-074", "PAMS-076")
def test_pymodbus_drives_the_pam_to_run_and_exchanges_variables(rig: tuple[AskedRig, int]) -> None:
    pam, port = rig
    client: Any = ModbusTcpClient("127.0.0.1", port=port, timeout=60)
    assert client.connect()
    words = Registers(client)
    (plan,) = ports_of(checked(PROGRAM, "program")[0])
    master = VmeMaster(plan.variables)
    carry_out(master.start_up({"DWI_MachPressure": 12}), words, time.sleep)
    assert not master.mistakes
    assert pam.get("pam/state") == "running"
    assert pam.get("pam/reports").split() == ["07..M01C", "07..M007", "07..M012", "07..M011"]
    assert pam.get("pam/DWI_MachPressure.0") == 12
    assert carry_out(master.put("DLI_MachHeadSpeed", -123_456, 3), words, time.sleep)
    until(lambda: pam.get("pam/DLI_MachHeadSpeed.3") == -123_456)
    pam.set("pam/DRO_MachHeadLevel.2", 0.125)
    assert carry_out(master.take(), words, time.sleep) == [("DRO_MachHeadLevel", 2, 0.125)]
    assert client.read_holding_registers(2047, count=2).isError()
    assert client.read_coils(0, count=1).isError()
    client.close()
