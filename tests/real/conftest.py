"""The running lab, started once for all tests of this folder, and its masters; the running ring, once for a file."""

import os
import signal
from collections.abc import Iterator

import pytest
import socketcand_answers
from lab_masters import CanopenMaster, Pump, canopen_master, modbus_tcp, socketcand
from lab_process import LabProcess
from ring_process import RingProcess

socketcand_answers.install()

collect_ignore = [] if os.environ.get("ROS_CANOPEN") else ["test_ros_canopen.py"]
"""The tests of a master that no registry has, and that need a checkout of it."""


@pytest.fixture(scope="session")
def running_lab() -> Iterator[LabProcess]:
    """Started as a user does; Ctrl-C ends it, and leaves nothing behind."""
    with LabProcess() as lab:
        pids = lab.until_ready().pids()
        yield lab
        pids |= lab.pids()
        assert lab.end(signal.SIGINT) == 0, lab.output()
        assert lab.left_behind(pids) == []


@pytest.fixture
def lab(running_lab: LabProcess) -> LabProcess:
    """The lab at rest, with 0.5 m in its tank."""
    running_lab.rest()
    return running_lab


@pytest.fixture
def master(lab: LabProcess) -> Iterator[CanopenMaster]:
    """python canopen by socketcand; the nodes are as after power-on."""
    with canopen_master(socketcand(lab)) as master:
        master.reset()
        yield master


@pytest.fixture
def pump(lab: LabProcess) -> Iterator[Pump]:
    """The pump drive, for pymodbus over TCP."""
    with modbus_tcp(lab) as client:
        yield Pump(client)


@pytest.fixture(scope="module")
def running_ring() -> Iterator[RingProcess]:
    """configs/ring.yaml."""
    with RingProcess() as ring:
        yield ring.until_ready().until_up()
        assert ring.end(signal.SIGINT) == 0, ring.output()


@pytest.fixture
def ring(running_ring: RingProcess) -> RingProcess:
    """At rest."""
    running_ring.rest()
    return running_ring
