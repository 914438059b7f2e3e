"""A master in another process drives a PAM through a shared memory, and through words over TCP."""

import socket
import time
from collections.abc import Sequence
from textwrap import indent

import pytest
from pam_port_kinds import KINDS
from pam_ports import GROUP, VME
from pam_programs import HEADER
from running_rig import AskedRig, until

from fieldrig.testing import free_port
from fieldrig_bus.dualport.shm import SharedMemory
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.ports import ports_of
from fieldrig_devices.pam.ports.masters.script import carry_out
from fieldrig_devices.pam.ports.masters.vme import VmeMaster

pytestmark = pytest.mark.system

PROGRAM = HEADER + GROUP + VME.replace("TIMEOUT = 500", "TIMEOUT = NONE")
RIG = """
time: real
buses:
  card: {{kind: dualport.shm}}
  lan: {{kind: tcp.server, listen: {{dualport: "127.0.0.1:{port}"}}}}
devices:
  pam:
    kind: "pam_port_kinds:PortHost"
    links: {{dualport: card, tcp: lan}}
    program: |
{program}
"""


class WordsOverTcp:
    """The memory by the protocol of docs/devices/pam/pam-ports.md."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=60)
        self._file = self._socket.makefile("rb")

    def read(self, word: int, count: int) -> Sequence[int]:
        self._socket.sendall(b"R" + word.to_bytes(2, "big") + count.to_bytes(2, "big"))
        assert self._file.read(1) == b"\0"
        data = self._file.read(2 * count)
        return [int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data), 2)]

    def write(self, word: int, values: Sequence[int]) -> None:
        head = b"W" + word.to_bytes(2, "big") + len(values).to_bytes(2, "big")
        self._socket.sendall(head + b"".join(value.to_bytes(2, "big") for value in values))
        assert self._file.read(1) == b"\0"

    def close(self) -> None:
        self._file.close()
        self._socket.close()


def test_a_master_maps_the_memory() -> None:
    port = free_port()
    with AskedRig(RIG.format(port=port, program=indent(PROGRAM, " " * 6)), KINDS) as rig:
        rig.until_ready()
        (plan,) = ports_of(checked(PROGRAM, "program")[0])
        shared = SharedMemory(rig.run / "dualport/card")
        master = VmeMaster(plan.variables)
        carry_out(master.start_up({"DWI_MachPressure": 3}), shared, time.sleep)
        assert rig.get("pam/state") == "running"
        assert rig.get("pam/DWI_MachPressure.0") == 3
        assert carry_out(master.put("DRI_MachHeadFactor", 0.5, -1), shared, time.sleep)
        until(lambda: rig.get("pam/DRI_MachHeadFactor.5") == 0.5)
        rig.set("pam/DLO_MachHeadPosition.1", 70_000)
        words = WordsOverTcp(port)  # the same memory by another way
        assert carry_out(master.take(), words, time.sleep) == [("DLO_MachHeadPosition", 1, 70_000)]
        words.close()
        shared.close()
        assert rig.end() == 0
