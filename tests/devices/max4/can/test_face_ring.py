"""A foreign CiA 402 master (python canopen) moves MC-4 drives over the MAx-4 and its ring."""

from typing import Any

import pytest
from can_face_bench import NODE, CanFaceBench


@pytest.fixture(scope="module")
def bench() -> CanFaceBench:
    return CanFaceBench("belt", "knife").boot()


@pytest.fixture(scope="module")
def node(bench: CanFaceBench) -> Any:
    master = bench.master()
    master.setup_402_state_machine()
    return master


@pytest.mark.long
@pytest.mark.manual("PD-004")
@pytest.mark.manual("PD-005")
@pytest.mark.manual("PD-206")
def test_a_foreign_master_homes_an_axis_and_drives_it_to_a_position(bench: CanFaceBench, node: Any) -> None:
    node.nmt.state = "OPERATIONAL"
    bench.run(20)
    node.sdo[0x6098].raw = 35
    node.op_mode = "PROFILED POSITION"
    node.state = "OPERATION ENABLED"
    assert (node.state, node.op_mode) == ("OPERATION ENABLED", "PROFILED POSITION")
    assert bench.axis("belt").is_controlled
    node.state = "SWITCHED ON"
    assert node.homing()
    assert node.sdo[0x6064].raw == pytest.approx(0, abs=20)
    node.state = "SWITCHED ON"
    node.op_mode = "PROFILED POSITION"
    node.state = "OPERATION ENABLED"
    before = bench.axis("belt").position
    node.sdo[0x6081].raw = 2_000_000
    node.sdo[0x607A].raw = 3_000_000
    node.controlword = 0x1F
    bench.run(1_500)
    assert not node.statusword & 0x0400
    bench.run(600)
    assert node.statusword & 0x1400 == 0x1400
    assert node.sdo[0x6064].raw == pytest.approx(3_000_000, abs=1_000)
    assert bench.axis("belt").position - before == pytest.approx(3_000_000, abs=1_000)
    node.state = "SWITCH ON DISABLED"
    bench.run(1_000)
    assert not bench.axis("belt").is_controlled


def enable(bench: CanFaceBench, node: Any, mode: int, axis: int = 1) -> None:
    first = 0x6000 + 0x800 * axis
    node.sdo[first + 0x60].raw = mode
    for word in (0x06, 0x07, 0x0F):
        node.sdo[first + 0x40].raw = word
    bench.run(300)
    assert node.sdo[first + 0x41].raw & 0x6F == 0x27


@pytest.mark.long
@pytest.mark.parametrize("mode", [3, 9])
def test_speeds_of_the_second_axis(bench: CanFaceBench, node: Any, mode: int) -> None:
    enable(bench, node, mode)
    node.sdo[0x68FF].raw = 3_000_000
    bench.run(1_000)
    assert node.sdo[0x686C].raw == pytest.approx(3_000_000, rel=0.01)
    node.sdo[0x6840].raw = 0x02
    bench.run(1_500)
    assert node.sdo[0x6841].raw & 0x6F == 0x40
    assert not bench.axis("knife").is_enabled


@pytest.mark.long
def test_torque_turns_the_second_axis(bench: CanFaceBench, node: Any) -> None:
    enable(bench, node, 10)
    node.sdo[0x6871].raw = 100
    bench.run(40)
    assert node.sdo[0x6877].raw == pytest.approx(100, abs=15)
    assert node.sdo[0x686C].raw > 0
    assert node.sdo[0x6876].raw > 100
    node.sdo[0x6840].raw = 0x00
    bench.run(2_000)
    assert not bench.axis("knife").is_controlled


@pytest.mark.long
@pytest.mark.parametrize("mode", [4, 10])
def test_a_torque_ends_at_a_position_limit_where_the_drive_holds_the_axis(
    bench: CanFaceBench, node: Any, mode: int
) -> None:
    """The controller then gives positions instead of torques, though no object has changed (607Dh of CiA 402-2)."""
    here = node.sdo[0x6864].raw
    node.sdo[0x687D][1].raw, node.sdo[0x687D][2].raw = here - 300_000, here + 300_000
    enable(bench, node, mode)
    node.sdo[0x6871].raw = 100
    bench.run(3_000)
    stopped = node.sdo[0x6864].raw
    assert here + 100_000 < stopped < here + 10_000_000
    bench.run(500)
    assert node.sdo[0x6864].raw == pytest.approx(stopped, abs=200), "it is held"
    node.sdo[0x6840].raw = 0x00
    bench.run(2_000)
    node.sdo[0x687D][1].raw, node.sdo[0x687D][2].raw = -(1 << 31), (1 << 31) - 1


@pytest.mark.long
@pytest.mark.manual("PD-028")
def test_the_service_channel_takes_its_time(bench: CanFaceBench, node: Any) -> None:
    window = node.sdo[0x2180]
    window[1].raw = 30  # S-0-0030, manufacturer version
    window[3].raw = 1
    assert window[4].raw == 1
    begin_ns = bench.rig.now_ns
    while window[4].raw == 1:
        bench.run(1)
    assert window[4].raw == 2
    assert bench.rig.now_ns - begin_ns > 5 * bench.max4.firmware.cycle_ns
    assert " V00." in bytes(window[6].raw).decode()


def test_the_service_channel_tells_what_a_drive_refuses(bench: CanFaceBench, node: Any) -> None:
    window = node.sdo[0x2181]
    window[1].raw = 0x7FFF
    window[3].raw = 1
    bench.run(500)
    assert (window[4].raw, window[5].raw) == (3, 0x1001)


@pytest.mark.long
def test_an_error_of_a_drive_is_a_fault_an_emcy_and_goes_by_fault_reset(bench: CanFaceBench, node: Any) -> None:
    enable(bench, node, 1)
    bench.take()
    number = bench.rig.add_fault("knife", {"what": "overtemperature", "of": "motor"})
    bench.run(1_500)
    emergencies = [frame for frame in bench.take() if frame.startswith("08A")]
    # 4310h, generic and temperature; 3117, axis 2
    assert emergencies[0].startswith("08A#10 43 09 2d 0c 02 ")
    assert (node.sdo[0x683F].raw, node.sdo[0x6841].raw & 0x4F, node.sdo[0x2101][1].raw) == (0x4310, 0x08, 3117)
    bench.rig.clear_fault("knife", number)
    bench.run(500)
    node.sdo[0x6840].raw = 0x80
    bench.run(1_000)
    assert (node.sdo[0x683F].raw, node.sdo[0x6841].raw & 0x4F, node.sdo[0x2101][1].raw) == (0x4310, 0x40, 0)
    assert "08A#00 00 00 00 00 00 00 00" in bench.take()


@pytest.mark.long
def test_a_broken_ring_is_a_fault_of_all_axes_and_heals_by_fault_reset() -> None:
    bench = CanFaceBench("belt", "knife").boot()
    node = bench.master()
    enable(bench, node, 1)
    number = bench.rig.add_fault("ring0", {"what": "break", "after": "belt"})
    bench.run(500)
    assert [node.sdo[index].raw & 0x4F for index in (0x6041, 0x6841)] == [0x08, 0x08]
    assert node.sdo[0x603F].raw == 0x7500
    bench.rig.clear_fault("ring0", number)
    bench.run(500)
    node.sdo[0x6040].raw = 0x80
    node.sdo[0x6840].raw = 0x80
    bench.run(6_000)
    assert [node.sdo[index].raw & 0x4F for index in (0x6041, 0x6841)] == [0x40, 0x40]
    enable(bench, node, 1)


@pytest.mark.long
def test_6072_limits_the_torque_of_the_drive_whatever_moves_it() -> None:
    bench = CanFaceBench("belt").boot()
    node = bench.master()
    assert bench.rig.get("max4", "belt.TorqueLimit") == 4_000
    for most in (300, 200, 150):
        node.sdo[0x6072].raw = most
    bench.run(500)
    assert bench.rig.get("max4", "belt.TorqueLimit") == 150
    enable(bench, node, 3, axis=0)
    node.sdo[0x6083].raw = 2_000_000_000
    node.sdo[0x60FF].raw = 60_000_000
    torques = [bench.run(4).axis("belt").torque for _ in range(30)]
    assert max(torques) == pytest.approx(150, abs=1)
    node.sdo[0x6072].raw = 60_000  # more than a drive has
    bench.run(500)
    assert bench.rig.get("max4", "belt.TorqueLimit") == 10_000
    node.nmt.state = "RESET"  # nothing was stored
    bench.run(500)
    assert (node.sdo[0x6072].raw, bench.rig.get("max4", "belt.TorqueLimit")) == (4_000, 4_000)


SWITCHES = {"I_bNeg": (-(2**40), -300_000), "I_bPos": (400_000, 2**40), "I_bHome": (50_000, 100_000)}
"""First and last position at which each switch is on, in increments."""


class SwitchedBench(CanFaceBench):
    """An axis with its limit switches and its home switch."""

    def __init__(self) -> None:
        terminals = {"belt": {"negative_limit": "I_bNeg", "positive_limit": "I_bPos", "home": "I_bHome"}}
        can_axes = {"node_ids": [NODE], "terminals": terminals}
        super().__init__("belt", can_axes=can_axes, inputs=dict.fromkeys(SWITCHES, ""))

    def run(self, ms: float) -> "SwitchedBench":
        for _ in range(round(ms)):
            super().run(1)
            if "belt" in self.max4.firmware.axes:
                self._switch(self.axis("belt").position)
        return self

    def _switch(self, position: int) -> None:
        for name, (first, last) in SWITCHES.items():
            is_on = first <= position <= last
            if self.max4.firmware.tree.parameter(f"{name}.Value").value is not is_on:
                self.rig.set("max4", f"{name}.Value", is_on)


@pytest.mark.long
def test_a_foreign_master_homes_a_drive_by_its_switches_and_runs_it_into_one() -> None:
    bench = SwitchedBench()
    node = bench.boot().master()
    node.setup_402_state_machine()
    for method, edge in ((24, 50_000), (25, 100_000), (27, 100_000), (30, 50_000), (17, -300_000)):
        node.sdo[0x6098].raw = method
        assert node.homing(), method
        assert node.sdo[0x6063].raw - node.sdo[0x6064].raw == pytest.approx(edge, abs=1_000), method
    node.sdo[0x6060].raw = 3
    node.sdo[0x60FF].raw = 2_000_000
    node.state = "OPERATION ENABLED"
    bench.run(1_500)
    assert node.sdo[0x6041].raw & 0x086F == 0x0827
    assert bench.axis("belt").velocity == pytest.approx(0, abs=100)
    assert 400_000 <= bench.axis("belt").position <= 450_000
    node.sdo[0x60FF].raw = -1_000_000
    bench.run(300)
    assert bench.axis("belt").velocity < -900_000
    assert node.sdo[0x6041].raw & 0x0800 == 0
