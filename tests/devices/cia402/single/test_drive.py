"""A single drive with motor and load: modes of operation, faults, terminals; torques and times from physics."""

from collections.abc import Callable
from itertools import pairwise
from math import pi, tau
from typing import Any

import pytest
from single_drive_bench import SingleDriveBench

from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.canopen.eds.check import check_eds
from fieldrig_devices.cia402.single.own_objects import EDS, eds_text
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

pytestmark = pytest.mark.long

PP, VL, PV, PT, HM, IP, CSP, CSV, CST = 1, 2, 3, 4, 6, 7, 8, 9, 10
TURN = 1_000_000
READY, ON, FAULT, DISABLED = 0x21, 0x23, 0x08, 0x40


@pytest.fixture
def bench() -> SingleDriveBench:
    return SingleDriveBench()


def test_the_eds_is_what_the_tables_say_and_has_no_fault() -> None:
    assert EDS.read_text() == eds_text()
    assert [mistake for mistake in check_eds(EDS) if "no clear mapping direction" not in mistake.what] == []


def test_the_node_says_that_it_is_a_servo_drive_with_every_mode(bench: SingleDriveBench) -> None:
    assert bench.get(0x1000) == 0x0002_0192
    assert bench.get(0x6502) == 0b11_1110_1111  # pp, vl, pv, tq, hm, ip, csp, csv, cst
    assert (bench.get(0x6075), bench.get(0x6076), bench.get(0x6079)) == (2_540, 1_270, 325_000)


def test_the_node_passes_our_conformance_cases() -> None:
    device = {"kind": "cia402.drive", "node_id": 3, "links": {"can": "can0"}}
    buses = {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}}
    rig = Rig(from_dict({"time": "virtual", "buses": buses, "devices": {"axis": device}}))
    report = conform_virtual(rig, "can0", Description(EDS, 3), choose(["OD", "PDO", "State"]))
    assert report.of(Verdict.FAILED) == []
    assert len(report.of(Verdict.PASSED)) > 30


def test_a_drive_without_torque_computes_nothing(bench: SingleDriveBench) -> None:
    bench.after(10)
    before = bench.drive.motor.at_ns
    bench.after(10_000)
    assert bench.drive.motor.at_ns == before


# ---- modes


def test_profile_position_reaches_its_target_in_the_time_of_its_profile(bench: SingleDriveBench) -> None:
    """Two turns at a turn per second, with ramps of 0.1 s: 2.1 s."""
    bench.enabled(PP).put(0x607A, 2 * TURN).control(0x1F)
    assert bench.until(lambda: bench.drive.axis.status_word & 0x0400 != 0) == pytest.approx(2_100, abs=30)
    bench.after(200)
    assert bench.get(0x6064) == pytest.approx(2 * TURN, abs=20)  # dry friction holds it there
    assert bench.read("position") == pytest.approx(2 * tau, abs=1e-4)


def test_a_second_set_point_waits_for_the_first(bench: SingleDriveBench) -> None:
    bench.enabled(PP).put(0x607A, TURN).control(0x1F).control(0x0F).put(0x607A, 0).control(0x1F)
    assert bench.status(0x1000) == 0x1000
    bench.until(lambda: bench.read("position") > 0.99 * tau)
    bench.until(lambda: abs(bench.read("position")) < 0.001)


def test_no_profile_runs_ahead_of_what_the_motor_can(bench: SingleDriveBench) -> None:
    """6000 min-1 are 100 turns per second.  A demand beyond them leaves a way that the motor makes up for later."""
    bench.put(0x607F, 0xFFFF_FFFF).put(0x6083, 1000 * TURN).put(0x6084, 1000 * TURN)
    bench.enabled(PV).put(0x60FF, 0x7FFF_FFFF).after(500)
    assert bench.get(0x606C) == pytest.approx(100 * TURN, rel=1e-3)
    assert bench.status(0x0800) == 0x0800
    bench.put(0x60FF, 0).after(200)
    assert abs(bench.get(0x606C)) < TURN / 10


@pytest.mark.parametrize("mode", [PT, CST])
@pytest.mark.parametrize(("most_rpm", "sign"), [(0xFFFF_FFFF, 1), (0xFFFF_FFFF, -1), (3000, 1)])
def test_a_torque_drives_the_motor_to_its_largest_speed_and_no_further(
    bench: SingleDriveBench, mode: int, most_rpm: int, sign: int
) -> None:
    bench.put(0x6080, most_rpm).enabled(mode).put(0x6071, sign * 300).after(2_000)
    assert 0.95 <= sign * bench.read("speed") / min(most_rpm, 6000) <= 1
    assert bench.status(0x0800) == 0x0800
    bench.put(0x6085, 1000 * TURN).control(0x02).after(300)
    assert abs(bench.get(0x606C)) < TURN / 10


@pytest.mark.parametrize(("before", "target"), [(PT, (0x6071, 300)), (CST, (0x6071, 300)), (CSV, (0x60FF, 90 * TURN))])
@pytest.mark.parametrize(("after", "bit"), [(IP, 0x0400), (CSP, 0x1000), (HM, 0x1400)])
def test_a_mode_without_a_set_point_brings_the_motor_to_rest_by_6084h(
    bench: SingleDriveBench, before: int, target: tuple[int, int], after: int, bit: int
) -> None:
    """CiA 402-2: the new mode's demand counts, and none of these has one yet.  90 turns/s at 100 turns/s2: 0.9 s.

    Bit 10 (ip: set-point reached) and bit 12 (csp: follows the set-point; hm: homed) do not come before.
    """
    bench.put(0x6084, 100 * TURN).put(0x6080, 5_400).put(0x6087, 1_000_000).enabled(before).put(*target).after(800)
    began = bench.get(0x606C)
    assert began > 80 * TURN
    bench.put(0x6060, after).after(500)
    assert bench.get(0x606C) == pytest.approx(began - 50 * TURN, rel=0.02)
    if after != HM:
        assert bench.status(bit) == 0
    bench.after(500)
    assert abs(bench.get(0x606C)) < TURN / 10
    assert bench.status(bit) == (0x0400 if after == HM else bit)


def test_profile_velocity_has_no_following_error_at_constant_speed(bench: SingleDriveBench) -> None:
    bench.enabled(PV).put(0x60FF, 10 * TURN).after(1_500)
    assert bench.get(0x606C) == pytest.approx(10 * TURN, rel=1e-3)
    assert bench.read("speed") == pytest.approx(600, rel=1e-3)
    assert bench.status(0x0400) == 0x0400
    assert abs(bench.get(0x60F4)) < 3_000


def test_velocity_mode_turns_the_motor_at_its_speed(bench: SingleDriveBench) -> None:
    bench.put(0x6042, 1_200).enabled(VL).control(0x7F).after(3_000)
    assert bench.read("speed") == pytest.approx(1_200, rel=1e-3)
    assert bench.get(0x6044) == pytest.approx(1_200, abs=1)


@pytest.mark.parametrize("mode", [PT, CST])
def test_a_torque_accelerates_the_inertia(mode: int) -> None:
    """20 % of 1.27 N m, less 0.02 N m of friction, on 8e-5 kg m2."""
    bench = SingleDriveBench(load={"inertia_kg_m2": 5e-5, "coulomb_nm": 0.02, "viscous_nm_s_per_rad": 0.0})
    bench.put(0x6087, 1_000_000).enabled(mode).put(0x6071, 200).after(11)
    began = bench.drive.motor.axis.v
    bench.after(20)
    assert (bench.drive.motor.axis.v - began) / 0.020 == pytest.approx((0.254 - 0.02) / 8e-5, rel=0.02)
    assert bench.get(0x6077) == 200


def test_csp_at_1_ms_follows_the_sync(bench: SingleDriveBench) -> None:
    """RPDO 3 with the SYNC, a turn per second; the drive is a cycle behind its set-points."""
    bench.put(0x1402, 1, 2).put(0x60C2, 1, 1).enabled(CSP)
    for place in range(0, 500_000, 1_000):
        bench.send(f"405#0F 00 {place.to_bytes(4, 'little').hex(' ')}", "080#")
        sent = bench.after(1)
    assert bench.get(0x6064) == pytest.approx(499_000, abs=2_500)
    assert [frame[:3] for frame in sent if frame[:3] == "385"] == []  # TPDO 3 answers the SYNC at once
    assert any(frame.startswith("385#") for frame in bench.send("080#"))


def test_csv_and_interpolated_position_move_too(bench: SingleDriveBench) -> None:
    bench.enabled(CSV).put(0x60FF, TURN).after(200)
    assert bench.read("speed") == pytest.approx(60, rel=0.02)
    bench.put(0x60FF, 0).after(500)
    begin = bench.get(0x6064)
    bench.put(0x60C2, 10, 1).put(0x6060, IP).control(0x1F).after(100)
    for step in range(1, 6):
        bench.put(0x60C1, begin + step * 1_000, 1)
    bench.after(200)
    assert bench.get(0x6064) == pytest.approx(begin + 5_000, abs=50)


# ---- homing on a machine with switches, an index and stops

MACHINE: dict[str, Any] = {
    "switches": {
        "negative_limit": {"low": -100.0, "high": -3.0},
        "positive_limit": {"low": 3.0, "high": 100.0},
        "home": {"low": 0.5, "high": 1.0},
    },
    "low_stop_rad": -3.5,
    "high_stop_rad": 3.5,
}
PER_RAD = TURN / tau


@pytest.mark.parametrize(
    ("method", "begin_rad", "home_rad"),
    [
        (17, 0.2, -3.0), (18, 0.2, 3.0), (19, 0.2, 0.5), (21, 2.0, 1.0), (1, 0.2, 0.0), (35, 0.2, 0.2),
        (-3, 0.2, 3.5), (-4, 0.2, -3.5), (-2, 0.2, 0.0), (-1, 0.2, 0.0),
    ],
)  # fmt: skip
def test_homing_finds_switch_index_or_stop(method: int, begin_rad: float, home_rad: float) -> None:
    """The index is at each whole turn, so between the stops it is at 0."""
    machine = MACHINE if method > 0 else {key: MACHINE[key] for key in ("low_stop_rad", "high_stop_rad")}
    bench = SingleDriveBench(**machine, initial_position_rad=begin_rad)
    bench.put(0x6098, method).put(0x6099, 200_000, 1).put(0x6099, 40_000, 2).enabled(HM).control(0x1F)
    bench.until(lambda: bench.drive.axis.status_word & 0x3400 == 0x1400)
    zero = bench.get(0x6063) - bench.get(0x6064)
    assert zero == pytest.approx(home_rad * PER_RAD, abs=600)
    assert bench.status(0x0008) == 0


def test_a_limit_switch_stops_the_motor(bench: SingleDriveBench) -> None:
    bench.enabled(PV).put(0x60FF, TURN).after(500)
    bench.wire("axis.positive_limit", True).after(200)
    assert bench.read("speed") == pytest.approx(0, abs=0.1)
    assert bench.status(0x0800) == 0x0800
    assert bench.get(0x60FD) == 2


# ---- terminals


def test_an_edge_of_a_probe_is_captured_between_two_cycles(bench: SingleDriveBench) -> None:
    bench.enabled(PV).put(0x60FF, 10 * TURN).after(1_500)
    bench.put(0x60B8, 0x0011).after(1)
    bench.clock.advance_to(bench.clock.now_ns() + 300_000)
    there = bench.drive.motor.present.position
    edge_ns = bench.clock.now_ns()
    bench.wire("axis.probe_1", True).after(2)
    assert bench.get(0x60BA) == round(there)
    assert bench.get(0x60D1) & 0xFFFF_FFFF == edge_ns & 0xFFFF_FFFF


def test_sto_takes_the_torque_away_and_the_motor_coasts(bench: SingleDriveBench) -> None:
    bench.enabled(PV).put(0x60FF, 10 * TURN).after(1_500)
    bench.wire("axis.sto", False).after(2)
    assert bench.status(0x6F) == DISABLED
    assert 500 < bench.read("speed") < 600
    bench.control(0x06).control(0x07).control(0x0F).after(5)
    assert bench.status(0x6F) in (READY, DISABLED)
    bench.wire("axis.sto", True).control(0x06).control(0x07).control(0x0F).after(5)
    assert bench.status(0x6F) == 0x27


def test_the_brake_lifts_before_operation_is_enabled() -> None:
    bench = SingleDriveBench(motor={"brake_torque_nm": 2.0, "brake_lift_ms": 40.0})
    bench.control(0x06).control(0x07).control(0x0F).after(30)
    assert bench.status(0x6F) == ON
    assert bench.until(lambda: bench.drive.axis.status_word & 0x6F == 0x27) == pytest.approx(10, abs=3)
    assert bench.wires.sent[-1] == Signal("axis.brake", True)
    bench.control(0x00).after(2)
    assert bench.wires.sent[-1] == Signal("axis.brake", False)


def test_inputs_and_outputs_are_bits_of_60fd_and_60fe() -> None:
    bench = SingleDriveBench(input_wires=["door"], output_wires=["lamp"])
    bench.wire("door", True).wire("axis.home", True)
    assert bench.get(0x60FD) == 1 << 18 | 1 << 2
    bench.put(0x60FE, 1 << 16, 2).put(0x60FE, 1 << 16, 1)
    assert bench.wires.sent[-1] == Signal("lamp", True)


def test_the_load_is_on_a_wire_as_a_motion() -> None:
    bench = SingleDriveBench(load={"gear_ratio": 10.0, "inertia_kg_m2": 0.001})
    bench.enabled(PV).put(0x60FF, 10 * TURN).after(2_000)
    last = next(sent for sent in reversed(bench.wires.sent) if isinstance(sent, Motion))
    assert (last.name, last.unit) == ("axis.position", "rad")
    assert last.speed == pytest.approx(tau, rel=1e-3)
    assert last.at(bench.clock.now_ns()) == pytest.approx(bench.read("position"), abs=2e-4)


# ---- the world, and faults


def test_a_load_torque_is_held_and_seen(bench: SingleDriveBench) -> None:
    bench.enabled(PP).wire("axis.load_torque", 0.635).after(500)
    assert bench.get(0x6077) == pytest.approx(500, abs=20)  # half of the rated torque, within dry friction
    assert abs(bench.get(0x6064)) < 10


def test_a_blocked_shaft_ends_in_a_following_error(bench: SingleDriveBench) -> None:
    bench.put(0x6065, 50_000).put(0x6066, 10).enabled(PV).put(0x60FF, TURN).after(500)
    number = bench.drive.add_fault({"what": "blocked"})
    bench.until(lambda: bench.drive.axis.status_word & 0x6F == FAULT, 2_000)
    assert bench.get(0x603F) == 0x8611
    bench.drive.clear_fault(number)
    bench.control(0x00).control(0x80).after(2)
    assert bench.status(0x6F) == DISABLED


def test_a_blocked_shaft_ends_in_an_overload_without_a_window(bench: SingleDriveBench) -> None:
    """The peak torque is borne for 3 s."""
    bench.enabled(PV).put(0x60FF, TURN).after(500)
    bench.wire("axis.blocked", True)
    assert bench.until(lambda: bench.get(0x603F) == 0x2350, 8_000) == pytest.approx(3_000, rel=0.15)


@pytest.mark.parametrize("reset_first", [False, True])
def test_a_lost_heartbeat_is_one_event_of_node_and_drive(bench: SingleDriveBench, reset_first: bool) -> None:
    """CiA 301 7.2.7.1: an EMCY once per event.  It is over once the heartbeat is back and the drive is reset."""
    bench.put(0x1016, 0x10 << 16 | 100, 1).enabled(PV).send("710#05")
    assert [frame for frame in bench.after(200) if frame[:3] == "085"] == ["085#30 81 11 00 00 00 00 00"]
    assert (bench.get(0x603F), bench.status(0x4F), bench.get(0x1003)) == (0x8130, FAULT, 1)
    ends: list[Callable[[], object]] = [lambda: bench.control(0x80), lambda: bench.send("710#05")]
    first, last = ends if reset_first else reversed(ends)
    first()
    bench.after(20)
    assert (bench.read("emcy.code"), bench.get(0x1001)) == (0x8130, 0x11)
    last()
    bench.after(20)
    assert (bench.read("emcy.code"), bench.get(0x1001), bench.get(0x1003)) == (0, 0, 1)


@pytest.mark.parametrize(
    ("fault", "code", "register"),
    [
        ({"what": "overtemperature"}, 0x4310, 0x09),
        ({"what": "overtemperature", "of": "drive"}, 0x4210, 0x09),
        ({"what": "overcurrent"}, 0x2310, 0x03),
        ({"what": "dc_link", "sort": "overvoltage"}, 0x3210, 0x05),
        ({"what": "dc_link"}, 0x3220, 0x05),
        ({"what": "encoder_signal"}, 0x7305, 0x21),
        ({"what": "error", "code": 0xFF01}, 0xFF01, 0x81),
        ({"what": "following_error"}, 0x8611, 0x21),
    ],
)
def test_each_fault_has_its_code_emcy_and_register(
    bench: SingleDriveBench, fault: dict[str, object], code: int, register: int
) -> None:
    bench.enabled(PP).take()
    number = bench.drive.add_fault(fault)
    sent = bench.after(20)
    assert f"085#{code & 0xFF:02x} {code >> 8:02x} {register:02x} 00 00 00 00 00" in sent
    assert (bench.get(0x603F), bench.status(0x4F), bench.get(0x1001)) == (code, FAULT, register)
    bench.control(0x80).after(5)
    assert bench.status(0x4F) == FAULT, "its cause is still there"
    bench.drive.clear_fault(number)
    bench.control(0x00).control(0x80).after(5)
    assert (bench.status(0x4F), bench.get(0x1001)) == (DISABLED, 0)


def test_each_further_error_has_its_emcy_until_all_are_reset(bench: SingleDriveBench) -> None:
    """CiA 301 7.2.7: one EMCY for each error event.  603Fh is the last error that occurred."""
    sent, numbers = [], []
    for code in (0x2310, 0x2311, 0x4310):
        numbers.append(bench.drive.add_fault({"what": "error", "code": code}))
        sent += [frame[:10] for frame in bench.after(5) if frame.startswith("085#")]
        assert bench.get(0x603F) == code
    assert sent == ["085#10 23 ", "085#11 23 ", "085#10 43 "]
    assert [bench.get(0x1003, place) & 0xFFFF for place in (0, 1, 2, 3)] == [3, 0x4310, 0x2311, 0x2310]
    for number in numbers:
        bench.drive.clear_fault(number)
    bench.control(0x80)
    assert [frame for frame in bench.after(5) if frame.startswith("085#")][-1] == "085#00 00 00 00 00 00 00 00"
    assert bench.status(0x6F) == DISABLED


def test_errors_of_one_cycle_have_an_emcy_each_in_their_order(bench: SingleDriveBench) -> None:
    """CiA 301 7.2.7: one EMCY for each error event, and one for each that has gone, with the rest of the register."""
    first, second, third = (bench.drive.add_fault({"what": "error", "code": code}) for code in (0x4310, 0x2310, 0x3210))
    sent = [frame[:13] for frame in bench.after(5) if frame.startswith("085#")]
    assert sent == ["085#10 43 09 ", "085#10 23 0b ", "085#10 32 0f "]
    assert (bench.get(0x603F), bench.get(0x1001)) == (0x3210, 0x0F)
    bench.drive.clear_fault(second)
    bench.control(0x80)
    assert [frame[:13] for frame in bench.after(5) if frame.startswith("085#")] == ["085#00 00 0d "]
    assert (bench.status(0x4F), bench.get(0x603F)) == (FAULT, 0x3210)
    for number in (first, third):
        bench.drive.clear_fault(number)
    bench.control(0x00).control(0x80)
    assert [frame[:13] for frame in bench.after(5) if frame.startswith("085#")] == ["085#00 00 05 ", "085#00 00 00 "]


def test_a_following_error_stays_signalled_beside_an_error_of_the_motor(bench: SingleDriveBench) -> None:
    bench.put(0x6065, 10).put(0x6066, 0).enabled(PV).put(0x60FF, 1_000_000)
    bench.wire("axis.blocked", True)
    bench.until(lambda: bench.get(0x603F) == 0x8611, 5_000)
    bench.after(1)
    bench.drive.add_fault({"what": "error", "code": 0x4310})
    assert [frame[:10] for frame in bench.after(5) if frame.startswith("085#")] == ["085#10 43 "]
    assert bench.get(0x1001) == 0x29


@pytest.mark.parametrize(("mode", "shown"), [(PP, 0x2000), (CSP, 0x2000), (PV, 0)])
def test_a_following_error_is_bit_13_where_the_mode_has_it(bench: SingleDriveBench, mode: int, shown: int) -> None:
    bench.enabled(mode)
    assert bench.status(0x2000) == 0
    number = bench.drive.add_fault({"what": "following_error"})
    bench.after(20)
    assert bench.status(0x2000) == shown
    bench.drive.clear_fault(number)
    bench.control(0x80).after(5)
    assert bench.status(0x2000) == 0


def test_the_code_of_a_following_error_is_that_of_the_make() -> None:
    bench = SingleDriveBench(behaviour={"following_error_code": 0x7320}).enabled(PP)
    bench.drive.add_fault({"what": "following_error"})
    bench.after(20)
    assert bench.get(0x603F) == 0x7320


def test_without_mains_nothing_is_enabled(bench: SingleDriveBench) -> None:
    bench.write_point("mains", False)
    bench.control(0x06).control(0x07).control(0x0F).after(5)
    assert bench.status(0x10) == 0
    assert bench.status(0x6F) != 0x27
    assert bench.get(0x6079) == 0


def test_a_reset_of_the_node_takes_the_torque_away(bench: SingleDriveBench) -> None:
    bench.enabled(PV).put(0x60FF, TURN).after(500)
    bench.send("000#81 05")
    bench.after(5)
    assert bench.status(0x6F) == DISABLED
    assert not bench.drive.motor.is_following


def test_torques_are_limited_by_6072_and_6073(bench: SingleDriveBench) -> None:
    bench.put(0x6073, 300).enabled(PV).wire("axis.blocked", True).put(0x60FF, TURN).after(1_000)
    assert bench.get(0x6077) == 300
    bench.put(0x6072, 100).after(50)
    assert bench.get(0x6077) == 100


def test_a_master_may_choose_a_whole_turn_as_the_unit(bench: SingleDriveBench) -> None:
    bench.put(0x6092, 1, 1).put(0x6081, 2).put(0x6083, 20).put(0x6084, 20).enabled(PP).put(0x607A, 3).control(0x1F)
    bench.until(lambda: bench.drive.axis.status_word & 0x0400 != 0)
    assert bench.read("position") == pytest.approx(3 * tau, abs=0.01)


def test_another_encoder_shows_in_608f_and_not_in_user_units() -> None:
    bench = SingleDriveBench(encoder_increments=4_096)
    assert bench.get(0x608F, 1) == 4_096
    bench.enabled(PP).put(0x607A, TURN).control(0x1F)
    bench.until(lambda: bench.drive.axis.status_word & 0x0400 != 0)
    bench.after(300)
    assert bench.read("position") == pytest.approx(2 * pi, abs=0.01)
    assert bench.get(0x6063) == pytest.approx(4_096, abs=2)


# ---- profiles with a limited jerk


def test_a_move_with_a_limited_jerk_takes_longer_and_ends_at_the_same_place(bench: SingleDriveBench) -> None:
    """Two turns at a turn a second: ramps of 1 / 10 + 10 / 100 = 0.2 s instead of 0.1 s, so 2.2 s instead of 2.1 s."""
    bench.put(0x6086, 3).put(0x60A4, 100 * TURN, 1).enabled(PP).put(0x607A, 2 * TURN).control(0x1F)
    assert bench.until(lambda: bench.drive.axis.status_word & 0x0400 != 0) == pytest.approx(2_200, abs=30)
    bench.after(200)
    assert bench.get(0x6062) == 2 * TURN
    assert bench.get(0x6064) == pytest.approx(2 * TURN, abs=20)


@pytest.mark.parametrize(("mode", "target"), [(PP, 0x607A), (PV, 0x60FF)])
def test_neither_acceleration_nor_jerk_of_the_demand_is_exceeded(
    bench: SingleDriveBench, mode: int, target: int
) -> None:
    """606Bh, each millisecond, while the target changes in the middle of a ramp, and a halt comes in another one."""
    bench.put(0x6086, 3).put(0x60A4, 50 * TURN, 1).put(0x6084, 5 * TURN).enabled(mode)
    speeds = []
    motion = bench.drive.axis.drive._motion
    for wanted, word in ((TURN, 0x0F), (TURN, 0x3F), (-TURN // 2, 0x0F), (-TURN // 2, 0x3F), (-TURN // 2, 0x13F)):
        bench.put(target, wanted).control(word)
        for _ in range(130):
            bench.after(1)
            speeds.append(motion.speed)
    rates = [(after - before) * 1_000 for before, after in pairwise(speeds)]
    jerks = [(after - before) * 1_000 for before, after in pairwise(rates)]
    assert max(map(abs, speeds)) > TURN / 4
    assert max(map(abs, rates)) <= 10.001 * TURN
    assert max(map(abs, jerks)) <= 50.01 * TURN


def test_a_set_point_that_is_passed_through_within_a_ramp_keeps_the_jerk(bench: SingleDriveBench) -> None:
    """Bit 9: the axis is still accelerating when it passes a fiftieth of a turn."""
    bench.put(0x6086, 3).put(0x60A4, 50 * TURN, 1).enabled(PP)
    bench.put(0x607A, TURN // 50).control(0x1F).control(0x0F).put(0x607A, TURN).control(0x021F)
    motion, speeds = bench.drive.axis.drive._motion, []
    for _ in range(1_600):
        speeds.append(motion.speed)
        bench.after(1)
    rates = [(after - before) * 1_000 for before, after in pairwise(speeds)]
    assert max(abs(after - before) * 1_000 for before, after in pairwise(rates)) <= 50.01 * TURN
    assert bench.get(0x6062) == TURN


def test_a_software_limit_is_kept_with_a_limited_jerk(bench: SingleDriveBench) -> None:
    bench.put(0x607D, 0, 1).put(0x607D, TURN, 2).put(0x6086, 3).put(0x60A4, 20 * TURN, 1)
    bench.enabled(PV).put(0x60FF, TURN).after(4_000)
    assert bench.get(0x6062) == pytest.approx(TURN, abs=1)
    assert bench.read("position") == pytest.approx(tau, abs=1e-3)


@pytest.mark.parametrize(("index", "value", "code"), [(0x6086, 1, 0x0609_0030), (0x6086, 2, 0x0609_0030)])
def test_profile_types_that_the_drive_lacks_are_refused(
    bench: SingleDriveBench, index: int, value: int, code: int
) -> None:
    """CiA 301, table 22: 0609 0030h is an invalid value of a parameter."""
    answer = bench.sdo(f"2b {index & 0xFF:02x} {index >> 8:02x} 00 {value:02x} 00 00 00")
    assert answer == f"80 {index & 0xFF:02x} {index >> 8:02x} 00 {code.to_bytes(4, 'little').hex(' ')}"
    assert bench.get(index) == 0
