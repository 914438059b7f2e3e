"""The start-up of the Simatic S5 DualPort (section 12.3; T29)."""

from datetime import UTC, datetime
from typing import Literal

import pytest
from pam_ports import GROUP, SIMATIC, PortBench, started_simatic

from fieldrig.clock import MS
from fieldrig_devices.pam.ports.masters.s5 import S5Master
from fieldrig_devices.pam.ports.masters.script import MasterError
from fieldrig_devices.pam.ports.options import PortOptions

PAM_READY, DUALPORT_READY = 1 << 3, 1 << 4
READY_CELL, HOST_CELL = 0xFEE // 2, 0x104 // 2
HOST_READY = 1 << 4
LIMITED = GROUP + SIMATIC.replace("MASTER_CONFIGURATION_TIMEOUT = NONE", "MASTER_CONFIGURATION_TIMEOUT = 300")


def meet(stale: int, later: str, pam_ready: Literal["set_first", "as_printed"]) -> PortBench:
    """Start both sides with PAM_READY as it was left; one of them is 200 ms later."""
    bench = PortBench(LIMITED, PortOptions(pam_ready=pam_ready))
    bench.memory.write(READY_CELL, [PAM_READY * stale])
    if later == "pam":
        bench.power_on_ns = 200 * MS
    else:
        bench.begin()
    if later == "host":
        bench.cycles(200)
    bench.play(S5Master(bench.plans[0], patience_ns=1_000_000_000).start_up())
    return bench


@pytest.mark.manual("PAMS-091", "PAMS-107")
@pytest.mark.parametrize("stale", [0, 1])
@pytest.mark.parametrize("later", ["pam", "host", "neither"])
def test_start_up_works_in_every_order_with_every_stale_value(stale: int, later: str) -> None:
    bench = meet(stale, later, "set_first")
    assert bench.kernel.codes == ["07..M01B", "07..M01D", "07..M006", "07..M011"]
    assert bench.ports.states == {"DualPort": "running"}
    assert bench.memory.read(READY_CELL, 1)[0] & DUALPORT_READY


@pytest.mark.manual("PAMS-091", "PAMS-092")
@pytest.mark.parametrize(
    ("stale", "later", "works"), [(1, "host", True), (1, "neither", True), (0, "pam", True), (0, "host", False)]
)
def test_the_printed_sequence_depends_on_the_order(stale: int, later: str, works: bool) -> None:
    """The PAM and its host wait for each other if PAM_READY is 0 when the PAM arrives first."""
    if works:
        assert meet(stale, later, "as_printed").ports.may_run
        return
    with pytest.raises(MasterError, match="PAM_READY has not come"):
        meet(stale, later, "as_printed")


@pytest.mark.manual("PAMS-091")
def test_the_pam_resets_host_ready_fifos_and_outputs() -> None:
    bench = PortBench(GROUP + SIMATIC)
    bench.memory.write(0, [0xFFFF] * 2048)
    bench.begin()
    assert bench.memory.read(HOST_CELL, 1) == [0xFFFF & ~HOST_READY]
    assert [bench.memory.read(address // 2, 1) for address in (0x100, 0x102, 0x900, 0x902)] == [[0]] * 4
    assert bench.memory.read(0x904 // 2, 1) == [0xFFFF & ~(1 << 5 | 1 << 13)]  # DFO_MachStopped and DFO_MachOk
    assert bench.memory.read(0x920 // 2, 5) == [0] * 5  # the pressure and four of 48 positions
    assert bench.memory.read(READY_CELL, 1) == [0xFFFF & ~DUALPORT_READY]


@pytest.mark.manual("PAMS-092", "PAMS-057")
def test_a_host_that_is_not_ready_is_fatal() -> None:
    bench = PortBench(GROUP + SIMATIC)
    bench.begin()
    bench.cycles(19_999)
    assert bench.kernel.codes == ["07..M01B"]
    bench.cycles()
    assert bench.kernel.codes == ["07..M01B", "07..F020"]
    bench.ports.fail(7, 0x020, datetime(1995, 10, 15, 14, 30, 45, tzinfo=UTC))
    assert bench.memory.read(0xFF0 // 2, 7) == [0x07, 0x020, 0x169F, 0x27AD, 0, 0, 0]
    bench.memory.write(READY_CELL, [0])
    bench.cycles(20)
    assert bench.memory.read(READY_CELL, 1) == [0]


@pytest.mark.manual("PAMS-092")
def test_a_host_that_does_not_send_its_inputs_is_fatal() -> None:
    bench = PortBench(LIMITED)
    bench.begin()
    for _ in range(2):
        bench.memory.write(READY_CELL, [0])
        bench.cycles()
    assert bench.kernel.codes == ["07..M01B", "07..M01D"]
    bench.cycles(299)
    assert bench.ports.states == {"DualPort": "waiting for the host"}
    bench.cycles()
    assert bench.kernel.codes[-1] == "07..F020"


@pytest.mark.manual("PAMS-091")
def test_initial_inputs_are_read_without_the_fifo() -> None:
    bench = PortBench(GROUP + SIMATIC)
    bench.begin()
    bench.play(
        S5Master(bench.plans[0]).start_up(
            {"DFI_MachEmergency": True, "DWI_MachHeadSpeed": [1, -2, 3, -4], "DFI_MachHeadTorque": [0, 1, 0, 1]}
        )
    )
    assert bench.value("DFI_MachEmergency") is True
    assert [bench.value("DWI_MachHeadSpeed", index) for index in range(4)] == [1, -2, 3, -4]
    assert [bench.value("DFI_MachHeadTorque", index) for index in range(4)] == [False, True, False, True]
    assert bench.kernel.events == []
    assert bench.memory.read(0x104 // 2, 1) == [1 << 11 | HOST_READY]  # cell #104 bit 11


def test_no_time_out_of_the_start_up_is_left_while_the_application_runs() -> None:
    bench = meet(0, "neither", "set_first")
    bench.item("DualPort").set_parameter("MASTER_INACTIVITY_TIMEOUT", "NONE")
    bench.cycles(1000)
    assert bench.kernel.codes[-1] == "07..M011"


def test_a_reset_begins_again() -> None:
    bench, master = started_simatic()
    bench.item("DFO_MachOk").do("set", ())
    bench.cycles(600)
    assert bench.item("DualPort").ask("error", ())
    bench.begin()
    assert not bench.ports.may_run
    assert not bench.item("DualPort").ask("error", ())
    assert bench.memory.read(0x904 // 2, 1) == [0]
    bench.play(master.start_up())
    assert bench.ports.may_run


def test_a_word_that_waits_for_its_period_is_not_updated_after_a_reset() -> None:
    bench, master = started_simatic()
    bench.cycles(11 - bench.kernel.cycle_number % 10)
    bench.play(master.put("DWI_MachPressure", 5))
    bench.cycles()
    bench.begin()
    bench.play(master.start_up())
    bench.memory.write(0x120 // 2, [9])  # not announced
    bench.cycles(20)
    assert bench.value("DWI_MachPressure") == 0


@pytest.mark.manual("PAMS-092")
def test_each_wait_for_pam_ready_has_its_own_time() -> None:
    bench = PortBench(GROUP + SIMATIC)
    bench.begin()
    bench.cycles(15_000)
    bench.memory.write(READY_CELL, [0])
    bench.cycles(15_000)
    assert bench.kernel.codes == ["07..M01B"]
    bench.cycles(5_001)
    assert bench.kernel.codes == ["07..M01B", "07..F020"]
