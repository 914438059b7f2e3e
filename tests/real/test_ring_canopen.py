"""The ring of configs/ring.yaml driven by python canopen: a CiA 402 master that is not ours.

The rig runs once for all tests here; each finds it at rest.
"""

import os
import signal
from collections.abc import Iterator

import pytest
from ring_process import AXES, DRIVES, PANEL, Plc, RingProcess, plc_of
from running_rig import until

pytestmark = [pytest.mark.real, pytest.mark.timeout(400)]

READY_TO_GO = 0x27
TURN = 1_000_000


@pytest.fixture
def plc(ring: RingProcess) -> Iterator[Plc]:
    with plc_of(ring) as plc:
        yield plc
        for axis in range(4):
            plc.axes.sdo[0x6040 + 0x800 * axis].raw = 0


def test_scanner_finds_the_axes_and_the_panel(plc: Plc) -> None:
    plc.network.scanner.search()
    until(lambda: {AXES, PANEL} <= set(plc.network.scanner.nodes))
    assert len({plc.axes.sdo[0x6502 + 0x800 * axis].raw for axis in range(4)}) == 1, "the same modes"
    assert plc.axes.sdo[0x1000].raw & 0xFFFF == 402


@pytest.mark.manual("PD-004", "PD-005", "PD-150")
def test_master_of_the_profile_brings_an_axis_to_a_position(ring: RingProcess, plc: Plc) -> None:
    axis = plc.axes
    axis.setup_402_state_machine(read_pdos=False)
    axis.nmt.state = "OPERATIONAL"
    axis.op_mode = "PROFILED POSITION"
    axis.state = "OPERATION ENABLED"
    assert axis.state == "OPERATION ENABLED"
    assert (ring.get("max4/infeed.AxisState"), ring.get("infeed/mc4_state")) == (3, 0x21)
    before = int(ring.get("max4/infeed.Position"))
    axis.sdo[0x6081].raw = 5 * TURN
    axis.sdo[0x607A].raw = axis.sdo[0x6064].raw + 3 * TURN
    axis.sdo[0x6040].raw = 0x1F
    until(lambda: axis.sdo[0x6041].raw & 0x1400 == 0x1400)
    assert int(ring.get("max4/infeed.Position")) - before == pytest.approx(3 * TURN, abs=2_000)
    axis.state = "SWITCH ON DISABLED"
    until(lambda: ring.get("max4/infeed.AxisState") == 1)


@pytest.mark.parametrize("axis", range(4), ids=DRIVES)
def test_speed_of_each_axis(ring: RingProcess, plc: Plc, axis: int) -> None:
    base = 0x800 * axis
    plc.enable(axis, 3)
    plc.axes.sdo[0x60FF + base].raw = 2 * TURN
    until(lambda: abs(float(ring.get(f"{DRIVES[axis]}/speed")) - 120) < 6)
    until(lambda: plc.axes.sdo[0x606C + base].raw == pytest.approx(2 * TURN, rel=0.1))
    plc.axes.sdo[0x60FF + base].raw = 0
    until(lambda: abs(float(ring.get(f"{DRIVES[axis]}/speed"))) < 2)
    plc.disable(axis)


@pytest.mark.manual("PD-091", "PD-100")
def test_fault_is_read_quitted_and_the_axis_goes_on(ring: RingProcess, plc: Plc) -> None:
    plc.enable(1, 3)
    plc.axes.sdo[0x68FF].raw = TURN
    until(lambda: float(ring.get("film/speed")) > 50)
    ring.fault("film", "overtemperature", "duration_ms=3000")
    until(lambda: plc.is_in(1, 0x08, 0x4F))
    assert (plc.axes.sdo[0x683F].raw, plc.axes.sdo[0x2101][1].raw) == (0x4310, 3117)
    until(lambda: ring.get("film/axis_state") == 5)
    assert ring.get("max4/DiagMsg") == "MC-4/film: motor temperature too high"

    def is_reset() -> bool:
        for word in (0x00, 0x80):
            plc.axes.sdo[0x6840].raw = word
        return plc.is_in(1, 0x40, 0x4F)

    until(is_reset)
    plc.enable(1, 3)
    plc.axes.sdo[0x68FF].raw = TURN
    until(lambda: float(ring.get("film/speed")) > 50)


@pytest.mark.manual("PD-162")
def test_emergency_stop_at_the_panel(ring: RingProcess, plc: Plc) -> None:
    plc.enable(0, 3)
    plc.axes.sdo[0x60FF].raw = TURN
    until(lambda: float(ring.get("infeed/speed")) > 50)
    plc.panel.sdo[0x6200][1].raw = 0
    until(lambda: all(ring.get(f"max4/{name}.AxisState") == 0 for name in DRIVES))
    assert not plc.is_in(0, READY_TO_GO)
    plc.panel.sdo[0x6200][1].raw = 1
    until(lambda: ring.get("max4/film.AxisState") == 1)


@pytest.mark.manual("PD-140")
def test_drive_whose_process_is_killed_opens_the_ring_until_it_is_back_and_acknowledged(ring: RingProcess) -> None:
    pid, restarts = ring.pid("outfeed"), int(ring.status()["processes"]["outfeed"]["restarts"])
    os.kill(pid, signal.SIGKILL)
    until(lambda: ring.get("max4/ring.state") == "down")
    assert 2560 in ring.codes()
    ring.until_back("outfeed", restarts + 1)
    ring.rest()
    assert 8568 in ring.codes()
