"""Tests of the lab on UDP multicast; test_lab_udp.py runs them in a network namespace of their own.

Elsewhere python-can would join the group on the computer's network card.
"""

from collections.abc import Iterator

import pytest
from canopen_network import BusOf
from lab_masters import OPERATIONAL, Heard, canopen_master, until_last
from lab_process import LabProcess
from running_rig import until
from terminal import Terminal

UDP: BusOf = {"interface": "udp_multicast", "channel": "239.74.163.2", "port": 43113, "fd": False}


@pytest.fixture(scope="module")
def lab() -> Iterator[LabProcess]:
    with LabProcess(can0="{kind: can.udp, fd: false}") as lab:
        lab.until_ready()
        lab.do(lab.lines()["can0 first lead the group to lo"].removeprefix("sudo "))
        yield lab


def test_canopen_master_drives_the_lab(lab: LabProcess) -> None:
    with canopen_master(UDP) as master:
        master.reset()
        assert master.sensor.sdo[0x1008].raw == "Level sensor"
        beats: list[Heard] = master.listen(0x705)
        master.start(master.io)
        until_last(beats, OPERATIONAL)
        master.send(0x305, "10 27 00 00 00 00 00 00")
        until(lambda: lab.get("tank/outlet") == 100)


def test_printed_lines_reach_the_nodes(lab: LabProcess) -> None:
    lines = lab.lines()
    assert lab.do(lines["io what it is"]) == "IO32"
    lab.do(lines["sensor start it"])
    until(lambda: lab.get("sensor/nmt.state") == "operational")
    with Terminal(lines["can0 watch"], lab.folder) as terminal:
        terminal.until_shown("705", "706")
        assert terminal.press("q") == 0
