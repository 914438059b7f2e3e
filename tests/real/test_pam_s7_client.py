"""snap7, an S7 client that is not ours, reads and writes the memory of a PAM, and is its S5 host."""

import time
from collections.abc import Iterator
from textwrap import indent
from typing import Any

import pytest
from pam_port_kinds import KINDS
from pam_ports import GROUP, SIMATIC
from pam_programs import HEADER
from pam_ways import DataBlock
from running_rig import AskedRig, until

from fieldrig.testing import free_port
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.ports import ports_of
from fieldrig_devices.pam.ports.masters.s5 import S5Master
from fieldrig_devices.pam.ports.masters.script import carry_out

snap7 = pytest.importorskip("snap7", reason="python-snap7 is not installed: pip install python-snap7")

pytestmark = pytest.mark.real

PROGRAM = HEADER + GROUP + SIMATIC.replace("20000", "NONE").replace("TIMEOUT = 500", "TIMEOUT = NONE")
RIG = """
time: real
buses:
  lan: {{kind: tcp.server, listen: {{s7: "127.0.0.1:{s7}", dualport: "127.0.0.1:{words}"}}}}
devices:
  pam:
    kind: "pam_port_kinds:PortHost"
    links: {{tcp: lan}}
    data_block: 7
    program: |
{program}
"""


@pytest.fixture(scope="module")
def rig() -> Iterator[tuple[AskedRig, int]]:
    ports = {"s7": free_port(), "words": free_port()}
    with AskedRig(RIG.format(**ports, program=indent(PROGRAM, " " * 6)), KINDS) as rig:
        rig.until_ready()
        yield rig, ports["s7"]


@pytest.fixture
def client(rig: tuple[AskedRig, int]) -> Iterator[Any]:
    client = snap7.client.Client()
    client.connect("127.0.0.1", 0, 2, rig[1])
    yield client
    client.disconnect()


@pytest.mark.manual("PAMS-088", "PAMS-091")
def test_snap7_is_the_host_of_a_simatic_dual_port(rig: tuple[AskedRig, int], client: Any) -> None:
    pam, _ = rig
    memory = DataBlock(client, 7, "little")
    (plan,) = ports_of(checked(PROGRAM, "program")[0])
    host = S5Master(plan)
    carry_out(host.start_up({"DWI_MachPressure": 12}), memory, time.sleep)
    assert pam.get("pam/state") == "running"
    assert pam.get("pam/DWI_MachPressure.0") == 12
    byte = client.db_read(7, 0x105, 1)
    snap7.util.set_bool(byte, 0, 3, True)
    client.db_write(7, 0x105, byte)
    until(lambda: pam.get("pam/DFI_MachEmergency.0"))
    assert carry_out(host.put("DWI_MachHeadSpeed", -5, 2), memory, time.sleep)
    until(lambda: pam.get("pam/DWI_MachHeadSpeed.2") == -5)
    pam.set("pam/DFO_MachOk.0", True)
    pam.set("pam/DWO_MachCurrentPressure.0", 400)
    assert carry_out(host.take(), memory, time.sleep) == [("DFO_MachOk", 0, True), ("DWO_MachCurrentPressure", 0, 400)]
    assert snap7.util.get_bool(client.db_read(7, 0x905, 1), 0, 5)


def test_snap7_reads_and_writes_more_than_one_pdu(client: Any) -> None:
    pattern = bytearray(range(1, 201)) * 5
    client.db_write(7, 0xA01, pattern)
    assert client.db_read(7, 0xA01, len(pattern)) == pattern
    assert client.db_read(7, 0xA00, 1) == bytearray(1)


@pytest.mark.parametrize(("block", "address"), [(8, 0), (7, 4095)])
def test_what_does_not_exist_is_refused(client: Any, block: int, address: int) -> None:
    with pytest.raises(Exception, match=r"(?i)error|address|exist"):
        client.db_read(block, address, 2)
