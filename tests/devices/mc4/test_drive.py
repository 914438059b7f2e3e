"""Whole drives on a ring with a master: enabling, moving, stopping, as the controller and the wires see it."""

from itertools import pairwise
from math import exp, isfinite, tau

import pytest
from device_of import device_of
from drive_line import Line
from hypothesis import given, settings
from hypothesis import strategies as st
from mc4_bench import BRAKE_PLATE, ENABLED, PLAIN_PLATE, SMALL_PLATE, DriveBench

from fieldrig.clock import MS, US
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.drives.axis import Axis, Mode
from fieldrig_devices.drives.loops import INNER_NS
from fieldrig_devices.mc4 import idns
from fieldrig_devices.mc4.drive import Mc4
from fieldrig_devices.mc4.feedback import Feedback
from fieldrig_devices.mc4.idns import READ_PLATE, STANDSTILL_TORQUE

BRAKED = {"motor": {"name_plate": BRAKE_PLATE}}
LOADED = {**BRAKED, "load": {"inertia_kg_m2": 0.02}}
HEAVY = {**BRAKED, "load": {"inertia_kg_m2": 0.4}}
"""1 s from 1000 1/min with 40 N m, more than StopTimeLim."""
KEYS = ("brake", "torque_on", "ready", "axis_state", "mc4_state", "diag_code")


def at_speed(bench: DriveBench, rpm: float = 1000.0, ms: int = 1_500) -> None:
    """Bring drive 1 up to a speed by its position commands."""
    per_cycle = rpm / 60 * 1_000_000 * 0.004
    cycles = ms // 4

    def path(cycle: int) -> int:
        ramp = min(cycle, cycles)
        return round(per_cycle * (ramp * ramp / 2 / cycles + max(cycle - cycles, 0)))

    bench.follow(path)
    bench.run(ms + 200)
    assert bench.get("speed") == pytest.approx(rpm, rel=0.01)


@pytest.mark.long
@pytest.mark.manual("PD-150", "PD-163")
def test_switching_on_takes_the_brake_disconnection_time() -> None:
    bench = DriveBench(BRAKED).up()
    assert bench.states() == (1, 0x10)
    bench.control = ENABLED
    seen = bench.trace(200, *KEYS, "brake_on")
    assert [line[1:] for line in seen] == [
        (False, False, True, 1, 0x10, 0, True),
        (True, True, True, 2, 0x20, 0, True),
        (True, True, True, 2, 0x20, 0, False),
        (True, True, True, 3, 0x21, 0, False),
    ]
    started, controlled = seen[1][0], seen[3][0]
    assert controlled - started == 100
    assert seen[2][0] - started == 60  # the plate's brake_lift_ms


@pytest.mark.long
@pytest.mark.manual("PD-150")
def test_positions_are_followed_after_that_only() -> None:
    bench = DriveBench({}).up()
    bench.control = ENABLED
    bench.follow(lambda cycle: 200 * cycle)
    bench.run(90)
    assert bench.master.drives[1].status & 0xC008 == 0xC000
    assert bench.get("position") == 0
    bench.run(60)
    assert bench.master.drives[1].status & 0xC008 == 0xC008
    bench.follow(lambda cycle: 200 * cycle)
    bench.run(400)
    assert bench.get("speed") == pytest.approx(200 * 250 * 60 / 1e6, rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("telegram", ["mdt", "mst"])
def test_set_position_goes_on_over_a_telegram_that_did_not_come(telegram: str) -> None:
    """The motor keeps its steady speed meanwhile, and follows the present command value afterwards."""
    bench = DriveBench({}).up().enable()
    bench.follow(lambda cycle: 200 * cycle)
    bench.run(500)
    speed, torque = bench.get("speed"), bench.get("torque")
    fault = {"what": "distort", "station": "d1", "telegram": telegram, "count": 1}
    bench.rig.add_fault("ring", fault)
    for _ in range(10):
        bench.run(4)
        assert bench.get("speed") == pytest.approx(speed, rel=1e-3)
        assert bench.get("torque") == pytest.approx(torque, abs=0.01)
    assert bench.number(28 if telegram == "mst" else 29) == 1
    stays = bench.feedback()[0]
    bench.follow(lambda _: 0)  # the base of `follow` is where it came under control
    bench.run(1_000)
    assert bench.feedback()[0] < stays
    assert bench.get("position") == pytest.approx(0, abs=2)


@pytest.mark.long
@pytest.mark.manual("PD-150", "PD-391", "PD-390")
def test_no_torque_before_the_dc_circuit_is_charged() -> None:
    bench = DriveBench({}, {})
    bench.rig.set("d1", "mains", False)
    bench.up().enable()
    assert (bench.states(1), bench.states(2)) == ((1, 0x10), (3, 0x21))  # a supply for each drive
    assert bench.master.drives[1].status & 0xC000 == 0x4000
    bench.rig.set("d1", "mains", True)
    bench.run(1_500)
    assert bench.states(1) == (3, 0x21)


@pytest.mark.long
@pytest.mark.manual("PD-150")
def test_no_torque_without_mains_though_the_dc_circuit_is_charged() -> None:
    """The voltage would suffice for ten seconds after the mains are off."""
    bench = DriveBench({}, {}).up()
    bench.rig.set("d1", "mains", False)
    bench.enable()
    assert bench.get("dc_bus") > 0.95 * 400 * 2**0.5
    assert (bench.states(1), bench.states(2)) == ((1, 0x10), (3, 0x21))
    assert (bench.get("torque_on"), bench.get("brake"), bench.code()) == (False, False, 0)
    bench.rig.set("d1", "mains", True)
    bench.run(300)
    assert bench.states(1) == (3, 0x21)


@pytest.mark.long
@pytest.mark.manual("PD-150")
@pytest.mark.parametrize("sort", ["phase", "undervoltage", "communication"])
def test_no_torque_while_the_supply_has_an_error(sort: str) -> None:
    bench = DriveBench({}).up()
    number = bench.rig.add_fault("d1", {"what": "dc_bus", "sort": sort})
    bench.enable()
    assert bench.get("torque_on") is False
    bench.rig.clear_fault("d1", number)
    bench.run(300)
    assert bench.get("torque_on") is False, "a message is pending"
    assert bench.command(99)
    bench.run(300)
    assert bench.get("torque_on") is True


@pytest.mark.long
@pytest.mark.manual("PD-150")
def test_mains_that_fail_under_torque_are_a_missing_phase() -> None:
    """Our reading: reaction B, so the drive stops with what the DC circuit still holds, and stays without torque."""
    bench = DriveBench(LOADED).up().enable()
    at_speed(bench, 100.0)
    bench.rig.set("d1", "mains", False)
    bench.run(8)
    assert (bench.states(), bench.code(), bench.get("torque_on")) == ((4, 0x40), 2195, True)
    bench.run(1_000)
    assert (bench.states(), bench.get("speed"), bench.get("torque_on")) == ((5, 0x02), 0, False)
    bench.rig.set("d1", "mains", True)
    bench.follow(None)
    assert bench.command(99)
    bench.run(1_000)
    assert bench.states() == (3, 0x21)


@pytest.mark.long
def test_dc_voltage_and_temperatures_are_those_of_the_instant() -> None:
    """Mains off at an instant: then volt = volt then * exp(-t / 110 s), at any instant, not in steps of 64 ms."""
    bench = DriveBench({}).up()
    bench.rig.set("d1", "mains", False)
    begin_ns, full_v = bench.rig.now_ns, bench.get("dc_bus")
    for ms in (1, 17, 40, 63, 64, 65, 100, 5_000):
        bench.rig.run_until(begin_ns + ms * MS)
        assert bench.get("dc_bus") == pytest.approx(full_v * exp(-ms / 1e3 / 110), abs=1e-6)
    bench.rig.set("d1", "ambient", 40.0)
    assert bench.get("amplifier_temperature") == pytest.approx(40.0, abs=0.1)


@pytest.mark.long
def test_position_between_two_cycles_lies_on_the_way_of_the_set_positions() -> None:
    bench = DriveBench({}).up().enable()
    bench.follow(lambda cycle: 200 * cycle)
    bench.run(500)
    seen = [bench.get("position")]
    begin_ns = bench.rig.now_ns
    for us in range(100, 12_001, 100):
        bench.rig.run_until(begin_ns + us * US)
        seen.append(bench.get("position"))
    assert {after - before for before, after in pairwise(seen)} <= {4, 5, 6}  # 200 in 4 ms
    assert seen[-1] - seen[0] == pytest.approx(600, abs=1)


@pytest.mark.parametrize("mode", [Mode.FREE, Mode.POSITION, Mode.SPEED, Mode.TORQUE])
@pytest.mark.parametrize("is_simulated", [False, True], ids=["real", "ideal"])
def test_looking_ahead_at_an_axis_is_where_it_goes(mode: Mode, is_simulated: bool) -> None:
    bench = DriveBench({"simulated": True} if is_simulated else {"load": {"viscous_nm_s_per_rad": 0.002}})
    axis: Axis = device_of(bench.rig, "d1", Mc4).machine.axis
    axis.brake(False)
    axis.control(mode)
    axis.load(0.5)
    if mode is Mode.POSITION:
        axis.follow(axis.set_increments + 1_600)
    else:
        axis.set_value(3.0)
    for _ in range(3):
        before = (axis.e, axis.v, axis.set_increments, axis.heat)
        shown = [axis.ahead(steps * INNER_NS) for steps in range(17)]
        assert (axis.e, axis.v, axis.set_increments, axis.heat) == before
        between = axis.ahead(8 * INNER_NS + INNER_NS // 2)
        low, high = sorted((shown[8].position, shown[9].position))
        assert low - 1e-6 <= between.position <= high + 1e-6
        axis.cycle()
        assert shown[16].position == pytest.approx(axis.position, abs=0.5 if is_simulated else 1e-3)  # whole ones
        assert shown[16].speed == pytest.approx(axis.v, rel=1e-9, abs=1e-9)
        assert shown[16].error == pytest.approx(axis.e, abs=1e-9)
        if mode is Mode.POSITION:
            axis.follow(axis.set_increments + 1_600)


@pytest.mark.long
@pytest.mark.manual("PD-151")
def test_lifting_enable_ramps_down_with_maximum_current() -> None:
    bench = DriveBench(LOADED).up().enable()
    at_speed(bench)
    bench.control = 0
    bench.run(8)
    assert bench.get("torque") == pytest.approx(-40.0, rel=0.02)  # 250 % of 10 A, 1.6 Nm/A
    seen = bench.trace(800, *KEYS)
    assert [line[1:] for line in seen] == [
        (True, True, True, 4, 0x40, 0),
        (False, True, True, 4, 0x41, 0),
        (False, False, True, 1, 0x10, 0),
    ]
    assert seen[2][0] - seen[1][0] == 52  # BrakeCouplingTime in whole cycles
    assert bench.get("brake_on")


@pytest.mark.long
@pytest.mark.manual("PD-152")
def test_heavy_load_passes_stop_time_limit_and_is_still_stopped() -> None:
    bench = DriveBench({**HEAVY, "parameters": {"stop_time_limit_ms": 600}}).up().enable()
    at_speed(bench, 1000.0, 2_500)
    bench.control = 0
    seen = bench.trace(2_500, *KEYS)
    assert [line[1:] for line in seen[1:]] == [
        (True, True, True, 4, 0x40, 0),
        (True, True, False, 4, 0x40, 2190),
        (False, True, False, 4, 0x41, 2190),
        (False, False, False, 5, 0x02, 2190),
    ]
    assert seen[2][0] - seen[1][0] == 600
    assert 600 < seen[3][0] - seen[1][0] < 1_200
    assert bench.code() == 2190


@pytest.mark.long
@pytest.mark.manual("PD-153", "PD-161")
@pytest.mark.parametrize(("plate", "is_held"), [(BRAKE_PLATE, True), (PLAIN_PLATE, False)])
def test_what_never_stops_in_time_is_left_to_its_brake(plate: str, is_held: bool) -> None:
    heavy = {"motor": {"name_plate": plate}, "load": {"inertia_kg_m2": 0.4}, "parameters": {"stop_time_limit_ms": 200}}
    bench = DriveBench(heavy).up().enable()
    at_speed(bench, 1000.0, 4_000)
    bench.control = 0
    seen = bench.trace(600, *KEYS)
    assert [line[5] for line in seen[1:5]] == [0x40, 0x40, 0x41, 0x42]
    assert [line[0] - seen[1][0] for line in seen[1:5]] == [0, 200, 400, 452]
    bench.run(4_000)
    assert (bench.get("speed") == 0) is is_held
    assert bench.states() == ((5, 0x02) if is_held else (4, 0x42))
    assert bench.code() == 2190  # no further message


@pytest.mark.long
@pytest.mark.manual("PD-154")
def test_reaction_b_opens_the_ready_contact_and_stops() -> None:
    bench = DriveBench(BRAKED).up().enable()
    at_speed(bench)
    bench.rig.add_fault("d1", {"what": "dc_bus"})
    seen = bench.trace(800, *KEYS)
    assert [line[1:] for line in seen] == [
        (True, True, False, 4, 0x40, 2106),
        (False, True, False, 4, 0x41, 2106),
        (False, False, False, 5, 0x02, 2106),
    ]


@pytest.mark.long
@pytest.mark.manual("PD-155")
def test_reaction_b_has_one_stop_time_limit() -> None:
    bench = DriveBench({**HEAVY, "parameters": {"stop_time_limit_ms": 300}}).up().enable()
    at_speed(bench, 1000.0, 2_500)
    bench.rig.add_fault("d1", {"what": "dc_bus"})
    seen = bench.trace(500, *KEYS)
    assert [line[5] for line in seen] == [0x40, 0x41, 0x42]
    assert seen[1][0] == pytest.approx(300, abs=4)
    assert set(bench.number(11).to_bytes(2, "little")) == {0x80, 0x00}
    assert bench.code() == 2106


@pytest.mark.long
@pytest.mark.manual("PD-156", "PD-100")
def test_reaction_a_frees_the_motor_at_once() -> None:
    bench = DriveBench(BRAKED).up().enable()
    at_speed(bench)
    number = bench.rig.add_fault("d1", {"what": "encoder_memory"})
    seen = bench.trace(600, *KEYS)
    assert [line[1:] for line in seen] == [
        (False, False, False, 4, 0x42, 1117),
        (False, False, False, 5, 0x02, 1117),
    ]
    assert not bench.command(99)  # it is still there
    bench.rig.clear_fault("d1", number)
    bench.follow(None)
    bench.run(1_500)  # the plate is read again
    assert bench.command(99)
    bench.run(200)
    assert (bench.states(), bench.code()) == ((3, 0x21), 0)


@pytest.mark.long
@pytest.mark.manual("PD-157")
def test_brake_coasts_with_reaction_a() -> None:
    load = {"coulomb_nm": 3.0}
    bench = DriveBench({**BRAKED, "load": load, "parameters": {"brake_coast": True}}).up().enable()
    at_speed(bench)
    bench.rig.add_fault("d1", {"what": "encoder_memory"})
    seen = bench.trace(600, "brake", "mc4_state")
    assert [line[1:] for line in seen] == [(True, 0x42), (False, 0x42), (False, 0x02)]
    assert seen[2][0] - seen[1][0] == 52


@pytest.mark.long
@pytest.mark.manual("PD-158")
def test_enable_coast_frees_the_motor() -> None:
    bench = DriveBench({"load": {"coulomb_nm": 0.5}, "parameters": {"enable_coast": True}}).up().enable()
    at_speed(bench)
    bench.control = 0
    bench.run(12)
    assert (bench.states(), bench.get("torque_on")) == ((4, 0x42), False)
    bench.run(500)
    assert bench.states() == (5, 0x02)
    bench.control = ENABLED
    bench.run(200)
    assert bench.states() == (3, 0x21)


@pytest.mark.long
@pytest.mark.manual("PD-159", "PD-100")
def test_overload_goes_back_to_where_it_came() -> None:
    bench = DriveBench(BRAKED).up().enable()
    at_speed(bench, 600.0)
    number = bench.rig.add_fault("d1", {"what": "overload"})
    overload_position = bench.number(idns.OVERLOAD_POSITION)
    assert abs(bench.get("position") - overload_position) <= 40_000  # what 600 1/min pass in a cycle
    seen = bench.trace(800, "mc4_state", "diag_code")
    assert [line[1:] for line in seen] == [(0x30, 3125), (0x32, 3125)]
    assert seen[1][0] < 800
    assert abs(bench.get("position") - overload_position) <= 2_000
    assert bench.get("ready")
    bench.rig.clear_fault("d1", number)
    bench.follow(None)
    assert bench.command(99)
    bench.run(100)
    assert (bench.states(), bench.code()) == ((3, 0x21), 0)


@pytest.mark.long
@pytest.mark.manual("PD-160")
def test_overload_position_not_reached_in_800_ms() -> None:
    bench = DriveBench(HEAVY).up().enable()
    at_speed(bench, 1000.0, 2_500)
    bench.rig.add_fault("d1", {"what": "overload"})
    seen = bench.trace(2_500, *KEYS)
    assert [(line[5], line[6]) for line in seen] == [(0x30, 3125), (0x40, 2191), (0x41, 2191), (0x02, 2191)]
    assert seen[1][0] == pytest.approx(800, abs=4)


@pytest.mark.long
@pytest.mark.manual("PD-162")
def test_inverter_enable_stops_and_prevents_a_start() -> None:
    bench = DriveBench({}).up().enable()
    at_speed(bench)
    bench.wires.send(Signal("d1.inverter_enable", False))
    bench.run(1_000)
    assert bench.states() == (0, 0x03)
    assert abs(bench.get("speed")) < 1
    bench.follow(None)
    bench.wires.send(Signal("d1.inverter_enable", True))
    bench.run(200)
    assert bench.states() == (3, 0x21)


def test_outputs_are_on_wires() -> None:
    bench = DriveBench(BRAKED).up().enable()
    bench.rig.add_fault("d1", {"what": "dc_bus"})
    bench.run(200)
    seen = [(signal.name, signal.value) for _, signal in bench.signals if signal.name in ("d1.ready", "d1.brake")]
    assert seen == [
        ("d1.ready", False), ("d1.brake", False), ("d1.ready", True), ("d1.brake", True), ("d1.ready", False),
        ("d1.brake", False),
    ]  # fmt: skip


def test_position_is_a_motion_on_a_wire() -> None:
    bench = DriveBench({"load": {"gear_ratio": 10.0}, "position_tolerance": 1e-3}).up().enable()
    at_speed(bench, 600.0)
    told = [signal for _, signal in bench.signals if signal.name == "d1.position"]
    last = told[-1]
    assert isinstance(last, Motion)
    assert last.speed == pytest.approx(tau, rel=1e-2)
    assert last.at(bench.rig.now_ns) == pytest.approx(bench.get("load_position"), abs=tau * 0.004 + 1e-3)
    assert len(told) < 500


def test_load_torque_is_felt() -> None:
    bench = DriveBench({"load": {"gear_ratio": 2.0}}).up().enable()
    bench.wires.send(Signal("d1.load_torque", 4.0, "N m"))
    bench.run(500)
    assert bench.get("torque") == pytest.approx(2.0, rel=1e-3)
    assert abs(bench.get("following_error")) < 5


@pytest.mark.manual("PD-173")
def test_a_turn_is_a_million_increments() -> None:
    bench = DriveBench({}).up().enable()
    before = bench.get("load_position")
    bench.follow(lambda cycle: min(2_000 * cycle, 1_000_000))
    bench.run(2_500)
    assert bench.get("load_position") - before == pytest.approx(tau, abs=1e-5)
    assert bench.number(116) == 1_000_000


@pytest.mark.manual("PD-174")
@pytest.mark.parametrize(
    ("plate", "turns", "position"),
    [
        (PLAIN_PLATE, 1234.5, 1_234_500_000),
        (PLAIN_PLATE, -3.25, -3_250_000),
        (PLAIN_PLATE, 2047.75, 2_047_750_000),
        (SMALL_PLATE, 12.25, 250_000),
        (SMALL_PLATE, 7.123457, 123_457),  # between two steps of the encoder: the analog signals have the rest
        (SMALL_PLATE, -5.123457, -123_457),
    ],
)
def test_absolute_position_is_known_at_power_on(plate: str, turns: float, position: int) -> None:
    bench = DriveBench({"motor": {"name_plate": plate}, "initial_turns": turns}).up()
    assert bench.feedback()[0] == position


def off_by(bench: DriveBench) -> float:
    """Increments between what the drive calls its position and where the load is, which is stiff and without a gear."""
    return float(bench.get("position") - bench.get("load_position") / tau * 1_000_000)


@pytest.mark.manual("PD-174")
def test_position_is_right_though_the_shaft_turns_while_the_encoder_answers() -> None:
    """The answer is of the instant at which the encoder was asked, some 9 ms before."""
    bench = DriveBench({"load": {"torque_nm": 0.2}, "initial_turns": 12.25})
    bench.up(2_000)
    assert bench.get("speed") < -1_000, "it has fallen from the start on"
    assert off_by(bench) == pytest.approx(0, abs=2)


@pytest.mark.long
def test_name_plate_that_is_read_again_in_motion_leaves_the_position() -> None:
    bench = DriveBench({}).up().enable()
    bench.follow(lambda cycle: 8_000 * cycle)
    bench.run(600)
    bench.control = 0x8000  # free
    bench.run(40)
    assert bench.get("speed") > 100
    assert bench.command(READ_PLATE)
    assert off_by(bench) == pytest.approx(0, abs=2)


@pytest.mark.long
def test_drive_is_not_enabled_while_its_name_plate_is_read() -> None:
    bench = DriveBench({}).up()
    ended: list[bool] = []
    bench.master.command(1, READ_PLATE, ended.append)
    bench.run(40)
    bench.control = ENABLED
    bench.run(160)
    assert (bench.states(), ended) == ((1, 0x10), [])
    bench.run(800)
    assert (bench.states(), ended) == ((3, 0x21), [True])


@pytest.mark.long
@pytest.mark.manual("PD-007", "PD-170", "PD-177")
def test_drive_configures_itself_from_the_name_plate() -> None:
    bench = DriveBench({}, {"motor": {"name_plate": SMALL_PLATE}}).up()
    assert bench.text(141, 1) == "SM-100/30/080/P1/45/M0"
    assert bench.text(141, 2) == "SM-070/60/010/P0/45/S0"
    assert (bench.number(111, 1), bench.number(109, 1)) == (5_000, 20_000)
    assert (bench.number(111, 2), bench.number(109, 2)) == (1_760, 7_040)
    assert (bench.number(113, 1), bench.number(113, 2)) == (50_000_000, 80_000_000)
    assert bench.number(100, 1) > 5 * bench.number(100, 2)
    bench.enable()
    assert bench.states(1) == bench.states(2) == (3, 0x21)


@pytest.mark.long
@pytest.mark.manual("PD-007")
def test_torque_is_limited_to_250_percent_of_the_amplifier() -> None:
    bench = DriveBench({**LOADED, "amplifier": {"continuous_current_a": 6.0}}).up().enable()
    at_speed(bench)
    bench.control = 0
    bench.run(8)
    assert bench.get("current") == pytest.approx(-15.0, rel=0.02)
    assert (bench.number(110), bench.number(112)) == (15_000, 6_000)


@pytest.mark.manual("PD-171", "PD-172", "PD-094")
@pytest.mark.parametrize(
    "drive",
    [
        pytest.param({"faults": [{"what": "encoder_memory"}]}, id="unreadable"),
        pytest.param({"faults": [{"what": "wrong_motor"}]}, id="wrong"),
        pytest.param({"motor": None}, id="missing"),
        pytest.param({"motor": {"name_plate": PLAIN_PLATE, "expected_type": "SM-140"}}, id="swapped"),
    ],
)
def test_bad_name_plate_is_1117_and_the_drive_is_not_enabled(drive: dict[str, object]) -> None:
    bench = DriveBench(drive).up(4_000)
    assert bench.code() == 1117
    assert bench.text(95) == "1117 encoder EEPROM read error"
    assert bench.number(11) == 1 << 5
    bench.enable(500)
    assert bench.states() == (5, 0x02)
    assert bench.master.drives[1].status & 0xE000 == 0x2000  # not ready, class 1 error
    assert not bench.get("ready")
    assert not bench.command(99)


@pytest.mark.long
def test_motor_at_an_encoder_of_its_own() -> None:
    links = {"ring": "ring", "wires": "wires", "encoder": "line"}
    encoder = {
        "kind": "fieldrig_devices.hiperface.device:SmEncoder",
        "name_plate": BRAKE_PLATE,
        "shaft_wire": "d1.shaft",
        "links": {"line": "line", "wires": "wires"},
    }
    drive = {"motor": None, "links": links, "initial_turns": 7.5}
    bench = DriveBench(drive, line={"kind": "serial.virtual", "baud": 9600, "parity": "E"}, sm=encoder).up(4_000)
    assert bench.code() == 0
    assert bench.get("motor_type") == "SM-140/30/200/P0/45/M1"
    assert bench.feedback()[0] == 7_500_000
    bench.enable()
    bench.follow(lambda cycle: min(2_000 * cycle, 500_000))
    bench.run(2_000)
    assert bench.get("turns", "sm") == pytest.approx(8.0, abs=1e-4)


@pytest.mark.long
def test_the_motor_at_the_cable_is_what_it_is_whatever_its_plate_says() -> None:
    """A plate of half the motor: the drive gives half the torque, which accelerates the whole inertia."""
    links = {"ring": "ring", "wires": "wires", "encoder": "line"}
    encoder = {
        "kind": "fieldrig_devices.hiperface.device:SmEncoder",
        "name_plate": PLAIN_PLATE,
        "shaft_wire": "d1.shaft",
        "links": {"line": "line", "wires": "wires"},
    }
    line = {"kind": "serial.virtual", "baud": 9600, "parity": "E"}
    bench = DriveBench({"links": links}, line=line, sm=encoder)
    bench.rig.add_fault("sm", {"what": "wrong_plate", "factor": 0.5})
    bench.up(4_000)
    assert bench.number(STANDSTILL_TORQUE) == 4_000
    bench.control = ENABLED | 0x0200
    bench.follow(lambda _: 250, idn=80)  # 25 % of 4 Nm
    bench.run(140)
    before = bench.get("speed")
    bench.run(40)
    assert bench.get("torque") == pytest.approx(1.0, rel=1e-3)
    grown = (bench.get("speed") - before) * tau / 60 / 0.040
    assert grown == pytest.approx(1.0 / 4.2e-4, rel=0.02), "rad/s2 with the inertia of the file's plate"


def test_encoder_without_a_plate_is_1117() -> None:
    links = {"ring": "ring", "encoder": "line"}
    bench = DriveBench({"motor": None, "links": links}, line={"kind": "serial.virtual"}).up(6_000)
    assert bench.code() == 1117
    assert bench.get("plate") != "read"


def with_encoder() -> DriveBench:
    """A drive whose encoder `sm` is a device of its own, on a serial line."""
    links = {"ring": "ring", "encoder": "line"}
    encoder = {
        "kind": "fieldrig_devices.hiperface.device:SmEncoder",
        "name_plate": PLAIN_PLATE,
        "links": {"line": "line"},
    }
    return DriveBench({"motor": None, "links": links}, line={"kind": "serial.virtual", "parity": "E"}, sm=encoder)


@pytest.mark.long
def test_quitting_tries_to_read_the_name_plate_again() -> None:
    bench = with_encoder()
    silent = bench.rig.add_fault("sm", {"what": "silent"})
    bench.up(6_000)
    assert bench.code() == 1117
    assert not bench.command(99)
    bench.rig.clear_fault("sm", silent)
    assert bench.command(99)
    assert (bench.code(), bench.get("motor_type")) == (0, "SM-100/30/080/P1/45/M0")


@pytest.mark.long
def test_encoder_that_tells_its_plate_and_no_position_is_asked_again_by_quitting() -> None:
    bench = with_encoder()
    silent = bench.rig.add_fault("sm", {"what": "silent", "start_ms": 448})  # just before the last question
    bench.up(6_000)
    assert bench.code() == 1105
    assert not bench.command(99)
    bench.run(8)
    assert bench.code() in (1105, 1117), "it still does not answer"
    bench.rig.clear_fault("sm", silent)
    assert bench.command(99)
    assert (bench.code(), bench.get("motor_type")) == (0, "SM-100/30/080/P1/45/M0")
    bench.enable()
    assert bench.states() == (3, 0x21)


@pytest.mark.parametrize("start_ms", range(440, 466, 5))
def test_memory_that_fails_at_any_instant_of_the_start_is_not_quitted(start_ms: int) -> None:
    """Type label, plate and position are read until 460 ms."""
    bench = DriveBench({"faults": [{"what": "encoder_memory", "start_ms": start_ms}]}).up()
    assert (bench.code(), bench.get("motor_type")) == (1117, "")
    assert not bench.command(99)


def test_reading_the_name_plate_does_not_mend_the_encoders_signals() -> None:
    bench = DriveBench({}).up()
    number = bench.rig.add_fault("d1", {"what": "encoder_signal"})
    bench.run(200)
    assert bench.code() == 1105
    assert bench.command(READ_PLATE)
    assert not bench.command(99)
    assert bench.code() == 1105
    bench.rig.clear_fault("d1", number)
    assert bench.command(99)
    assert bench.code() == 0


@pytest.mark.manual("PD-030")
def test_simulated_drive_is_where_it_is_told_and_has_no_errors() -> None:
    bench = DriveBench({"simulated": True, "motor": None}).up().enable()
    bench.follow(lambda cycle: 50_000 * cycle)
    bench.run(400)
    assert (bench.code(), bench.states()) == (0, (3, 0x21))
    assert bench.get("following_error") == 0
    assert bench.get("position") > 4_000_000
    places = []
    for _ in range(9):
        places.append(bench.get("position"))
        bench.run(0.4)
    assert [after - before for before, after in pairwise(places)] == [5_000] * 8, "a tenth of a cycle of 4 ms"
    bench.rig.add_fault("d1", {"what": "dc_bus"})
    bench.run(100)
    assert bench.code() == 0
    bench.control = 0
    bench.run(100)
    assert bench.command(READ_PLATE), "there is none, and none is needed"
    assert (bench.code(), bench.states()) == (0, (1, 0x10))


@pytest.mark.manual("PD-176")
def test_motor_temperature_stops_the_drive() -> None:
    bench = DriveBench({"language": "en"}).up().enable()
    bench.rig.add_fault("d1", {"what": "overtemperature"})
    bench.run(300)
    assert (bench.code(), bench.states()) == (3117, (5, 0x02))
    assert bench.text(95) == "3117 motor temperature too high"
    bench.rig.set("d1", "ambient", 90.0)
    bench.run(100)


@pytest.mark.parametrize(
    ("fault", "code"),
    [
        ({"what": "overtemperature", "of": "amplifier"}, 3193),
        ({"what": "dc_bus", "sort": "undervoltage"}, 2194),
        ({"what": "dc_bus", "sort": "overvoltage"}, 1108),
        ({"what": "dc_bus", "sort": "phase"}, 2195),
        ({"what": "encoder_signal"}, 1105),
    ],
)
def test_faults_have_their_codes_and_end(fault: dict[str, object], code: int) -> None:
    bench = DriveBench({}).up().enable()
    bench.rig.add_fault("d1", {**fault, "duration_ms": 500.0})
    bench.run(400)
    assert (bench.code(), bench.states()) == (code, (5, 0x02))
    assert not bench.command(99)
    bench.run(400)
    assert bench.command(99)
    bench.run(400)
    assert (bench.code(), bench.states()) == (0, (3, 0x21))


def test_low_24_v_is_shown_and_does_not_stop_it() -> None:
    bench = DriveBench({}).up().enable()
    bench.rig.add_fault("d1", {"what": "supply_24v", "start_ms": 100.0})
    bench.run(50)
    assert bench.code() == 0
    bench.run(200)
    assert (bench.code(), bench.states()) == (7134, (3, 0x21))


@pytest.mark.long
def test_stuck_brake_ends_as_a_following_error() -> None:
    bench = DriveBench({**BRAKED, "amplifier": {"continuous_current_a": 4.0}}).up()  # 16 N m against 24
    bench.rig.add_fault("d1", {"what": "stuck_brake"})
    bench.enable()
    assert bench.get("brake_on")
    bench.follow(lambda cycle: 50_000 * cycle)
    bench.run(600)
    assert bench.code() == 3196
    assert bench.get("position") == 0
    assert bench.number(11) == 1 << 11


def test_enable_lost_by_fault() -> None:
    bench = DriveBench({}).up().enable()
    number = bench.rig.add_fault("d1", {"what": "enable_lost"})
    bench.run(300)
    assert bench.states() == (0, 0x03)
    assert bench.rig.faults("d1")[number]["state"] == "on"
    bench.rig.clear_fault("d1", number)
    bench.run(300)
    assert bench.states() == (3, 0x21)


@pytest.mark.long
def test_real_overload_switches_off() -> None:
    bench = DriveBench({"load": {"torque_nm": 0.0}}).up().enable()
    bench.rig.set("d1", "load_torque", 20.0)
    bench.run(20_000)
    assert bench.code() == 3125
    assert bench.states() == (4, 0x32)


@pytest.mark.long
def test_ring_failure_stops_the_drive() -> None:
    bench = DriveBench({}, {}).up().enable()
    at_speed(bench)
    number = bench.rig.add_fault("ring", {"what": "break", "after": "d1"})
    bench.run(1_000)
    assert bench.get("diag_code", "d2") == 2112
    assert max(abs(bench.get("speed", name)) for name in ("d1", "d2")) < 1
    assert bench.get("torque_on", "d2") is False
    bench.rig.clear_fault("ring", number)
    bench.control = 0
    bench.follow(None)
    bench.master.request_phase(4)
    bench.run(4_000)
    assert bench.master.phase == 4, bench.events
    assert bench.command(99, address=2)
    bench.enable()
    assert bench.states(2) == (3, 0x21)


def test_velocity_and_torque_modes() -> None:
    bench = DriveBench({"load": {"viscous_nm_s_per_rad": 0.1}}).up()
    bench.control = ENABLED | 0x0100
    bench.follow(lambda _: 6_000_000, 36)  # 600 1/min
    bench.run(800)
    assert bench.get("speed") == pytest.approx(600.0, rel=1e-4)
    bench.control = ENABLED | 0x0200
    bench.follow(lambda _: 500, 80)  # 50 % of 8 N m
    bench.run(400)
    assert bench.get("torque") == pytest.approx(4.0, rel=1e-6)


def test_halt_stops_under_control_and_goes_on() -> None:
    bench = DriveBench({}).up().enable()
    at_speed(bench)
    bench.control = 0xC000
    bench.run(300)
    assert (bench.states(), bench.get("speed")) == ((3, 0x21), pytest.approx(0, abs=0.1))
    assert not bench.master.drives[1].status & 8


def test_drive_enable_taken_away_alone_frees_the_motor() -> None:
    bench = DriveBench({}).up().enable()
    at_speed(bench)
    bench.control = 0x8000
    bench.run(12)
    assert not bench.get("torque_on")


@pytest.mark.manual("PD-135")
def test_stands_without_a_ring_and_keeps_looking() -> None:
    bench = DriveBench({})
    bench.run(5_000)
    assert (bench.get("phase"), bench.get("stage")) == (0, "waiting")
    bench.rig.set("d1", "inverter_enable", False)
    bench.run(100)
    assert bench.get("axis_state") == 0


@pytest.mark.long
@pytest.mark.manual("PD-013")
@pytest.mark.parametrize("cycle_ms", [1, 2, 4])
def test_runs_at_every_cycle_of_the_ring(cycle_ms: int) -> None:
    bench = DriveBench({}, cycle_ms=cycle_ms).up().enable()
    bench.follow(lambda cycle: 1_000 * cycle)
    bench.run(600)
    assert bench.get("speed") == pytest.approx(1_000 / cycle_ms * 0.06, rel=1e-3)
    assert abs(bench.get("following_error")) <= 1


DOUBLE = st.integers(-(2**31), 2**31 - 1)
WORDS = st.tuples(
    st.integers(0, 0xFFFF).map(lambda word: word | 0xC000), DOUBLE, DOUBLE, st.integers(-(2**15), 2**15 - 1)
)


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(st.lists(WORDS, min_size=1, max_size=20))
def test_no_command_upsets_it(words: list[tuple[int, int, int, int]]) -> None:
    bench = DriveBench({**LOADED, "parameters": {"idns": {"S-0-0159": 2**31 - 1}}}).up(1_200).enable(150)
    for control, *commands in words:
        bench.raw = (control & 0xFFC0, *commands)
        bench.run(20)
        assert bench.master.phase == 4
    assert isfinite(bench.get("speed"))
    assert abs(bench.get("speed")) < 10_000


def test_a_second_without_cycles_is_made_up_for() -> None:
    bench = DriveBench({"load": {"coulomb_nm": 0.1}}).up().enable()
    at_speed(bench)
    bench.master.stop()
    bench.run(5_000)
    assert (bench.get("phase"), bench.get("diag_code"), bench.get("torque_on")) == (0, 2112, False)
    assert abs(bench.get("speed")) < 1


@pytest.mark.manual("PD-156", "PD-100")
def test_reaction_a_is_not_quitted_while_the_motor_still_turns() -> None:
    bench = DriveBench({}).up().enable()
    bench.follow(lambda cycle: 8_000 * cycle)  # 120 1/min
    bench.run(600)
    bench.rig.add_fault("d1", {"what": "encoder_signal", "duration_ms": 20})
    bench.run(60)
    assert not bench.command(99), "its cause is over, but the motor coasts"
    assert (bench.code(), bench.states()) == (1105, (4, 0x42))
    bench.rig.set("d1", "load_torque", 0.02)  # brakes it
    while bench.get("speed") > 9:
        bench.run(4)
    bench.rig.set("d1", "load_torque", 0.0)
    bench.run(100)
    assert bench.states() == (5, 0x02)
    assert bench.command(99)
    assert bench.code() == 0


@pytest.mark.manual("PD-164")
def test_another_operation_mode_has_its_following_error_and_the_first_has_none_again() -> None:
    """Primary mode without, secondary mode 3 with a following error, which is speed over Kv."""
    bench = DriveBench({}).up().enable()
    bench.follow(lambda cycle: 200 * cycle)
    for mode, error in ((0, 0), (0x0300, 50_000 / 60), (0, 0)):
        bench.control = ENABLED | mode
        bench.run(500)
        assert bench.get("following_error") == pytest.approx(error, rel=0.01, abs=2)


@pytest.mark.long
def test_load_behind_a_coupling_lags_and_swings_out() -> None:
    """20 Nm/rad between motor and load: the feedback of the load, S-0-0053, is another than that of the motor."""
    load = {"inertia_kg_m2": 0.002, "stiffness_nm_per_rad": 20.0, "damping_nm_s_per_rad": 0.02, "torque_nm": 2.0}
    bench = DriveBench({"motor": {"name_plate": BRAKE_PLATE}, "load": load}).up().enable(5_000)
    twist = 2.0 / 20.0 / tau * 1_000_000
    assert bench.number(51) - bench.number(53) == pytest.approx(twist, rel=0.02)
    assert bench.get("torque") == pytest.approx(2.0, rel=0.01)
    before = bench.get("load_position")
    bench.follow(lambda cycle: min(4_000 * cycle, 1_000_000))
    apart: list[float] = []
    for _ in range(500):
        bench.run(4)
        apart.append(bench.get("position") / 1_000_000 * tau - bench.get("load_position"))
    assert max(apart) - min(apart) > 0.02, "it is no stiff shaft"
    assert max(apart[-50:]) - min(apart[-50:]) < 5e-3, "it comes to rest"
    assert bench.get("load_position") - before == pytest.approx(tau, abs=2e-3)


@pytest.mark.long
@pytest.mark.manual("PD-176")
def test_work_warms_the_winding() -> None:
    """Holding 6.5 of 8 Nm warms the motor by 40 K times the square of that share, and by 63 % of it after 60 s."""
    bench = DriveBench({"load": {"coulomb_nm": 0.5}}).up().enable()
    bench.rig.set("d1", "load_torque", 6.5)
    bench.run(60_000)
    rise = 40 * (bench.get("torque") / 8) ** 2 * 0.632
    assert bench.get("torque") == pytest.approx(6.5, abs=0.5), "friction may help, or be in the way"
    assert bench.get("motor_temperature") - bench.get("casing_temperature") == pytest.approx(rise, rel=0.03)
    assert 25.5 < bench.get("casing_temperature") < 27
    assert bench.number(383) == pytest.approx(bench.get("motor_temperature") * 10, abs=1)
    bench.run(30_000)
    assert bench.code() == 0


@pytest.mark.manual("PD-008")
def test_torque_is_limited_to_the_motors_peak_whatever_the_amplifier_can() -> None:
    bench = DriveBench({"amplifier": {"continuous_current_a": 100.0}, "load": {"inertia_kg_m2": 10.0}}).up().enable()
    assert bench.write(92, (10_000).to_bytes(2, "little")) == b""
    bench.control = ENABLED | 0x0200
    bench.follow(lambda _: 9_000, idn=80)  # 900 % of 8 Nm
    bench.run(100)
    assert bench.get("torque") == pytest.approx(32.0, rel=1e-3)


@pytest.mark.manual("PD-007", "PD-177")
def test_speed_is_limited_to_the_motors_own_whatever_the_master_writes() -> None:
    bench = DriveBench({"parameters": {"idns": {"S-0-0159": 2**31 - 1}}}).up()
    assert bench.write(91, (90_000_000).to_bytes(4, "little")) == b""  # 9000 1/min
    bench.enable()
    bench.follow(lambda cycle: 1_000_000 * cycle)  # 15000 1/min
    bench.run(300)
    assert bench.get("speed") == pytest.approx(5_000, rel=1e-3)


@pytest.mark.long
def test_drive_at_rest_reckons_nothing_anew_until_something_wakes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    encoded: list[int] = []
    encode = Feedback.encode

    def spy(feedback: Feedback) -> bytes:
        encoded.append(line.rig.now_ns)
        return encode(feedback)

    line = Line(2, wires=True)
    line.rig.set("max4", "d1.ControllerEnable", False)
    line.rig.set("max4", "d2.ControllerEnable", False)
    line.run(500)
    monkeypatch.setattr(Feedback, "encode", spy)
    line.run(100)
    assert len(encoded) <= 4, "only when it looks at what is slow"
    line.rig.set("d1", "load_torque", 1.0)
    line.run(50)
    assert len(encoded) > 40, "it is pulled away"
