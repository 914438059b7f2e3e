"""The controller on a ring of MC-4 drives: phase-up, axes, failures, and what the log says of them."""

import itertools
from collections.abc import Iterator
from itertools import accumulate, count

import pytest
from max4_bench import Bench, GivenSetValues

from fieldrig.clock import MS, VirtualClock
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.max4.axes.axis import AxisState, Mode, SetValues
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.process import RealTimeProcess
from fieldrig_devices.max4.ring.drive_end import RingDrive
from fieldrig_devices.max4.settings import ProcessTimes
from fieldrig_devices.sercos.idn import ServiceError

pytestmark = pytest.mark.long


@pytest.mark.manual("PD-001")
@pytest.mark.manual("PD-132")
@pytest.mark.manual("PD-135")
def test_boot_brings_the_ring_up_and_reads_the_drives() -> None:
    bench = Bench("belt", "knife").boot().run(3_000)
    assert (bench.get("ring.state"), bench.get("ring.phase"), bench.get("led.bus")) == ("up", 4, "on")
    assert bench.codes() == [8002, 8003]
    assert bench.get("belt.FirmwareVersion") == "MC-4/11/22/400 V00.07.00"
    assert (bench.get("belt.AxisState"), bench.get("belt.MC4State")) == (1, 0x10)
    assert bench.get("knife.BrakeDisconnectionTime") == 100


@pytest.mark.manual("PD-170")
def test_motor_data_of_the_name_plate_are_in_the_tree() -> None:
    bench = Bench("belt").boot().run(5_000)
    assert str(bench.get("belt.MotorType")).startswith("SM-100")
    assert float(bench.get("belt.RatedTorque")) > 0


@pytest.mark.manual("PD-133")
@pytest.mark.manual("PD-319")
@pytest.mark.parametrize("ms", [1, 2, 4])
def test_cycle_time_is_a_parameter(ms: int) -> None:
    bench = Bench("belt", cycle_ms=ms).boot()
    before = int(bench.get("cycles"))
    bench.run(400)
    assert int(bench.get("cycles")) - before == 400 // ms
    assert bench.get("CycleTime") == ms


def test_axis_under_control_follows_a_set_value_a_cycle() -> None:
    bench = Bench("belt").boot().run(2_000).enable("belt")
    axis = bench.axis("belt")
    assert axis.is_controlled
    start = axis.position
    given = GivenSetValues(start + 500 * step for step in range(1, 101))
    axis.follow(given)
    assert given.begun == [start]
    bench.run(400)
    assert given.asked == 100
    assert axis.set_value == start + 50_000
    bench.run(400)
    assert abs(axis.position - start - 50_000) < 50
    assert abs(axis.following_error) < 50


def test_positions_go_on_over_32_bits() -> None:
    """A drive that shows no more than 32 bits goes once round."""
    bench = Bench("belt").boot()
    drive = RingDrive(bench.axis("belt"), None, lambda _axis, _code: None)
    positions = []
    for raw in (2**31 - 10, -(2**31) + 10, 2**31 - 5):
        drive.drive.values = (0, 0, raw, 0, 0, 0x0321, 0)
        drive.take()
        positions.append(bench.axis("belt").position)
    assert positions == [2**31 - 10, 2**31 + 10, 2**31 - 5]


@pytest.mark.parametrize(("mode", "value"), [(Mode.VELOCITY, 2_000_000.0), (Mode.TORQUE, 20.0)])
def test_axis_takes_speeds_and_torques(mode: Mode, value: float) -> None:
    bench = Bench("belt").boot().run(2_000).enable("belt")
    axis = bench.axis("belt")
    before = axis.position
    axis.follow(GivenSetValues(iter([value]), mode))
    bench.run(500)
    assert axis.mode is mode
    assert axis.position - before > 100_000
    if mode is Mode.VELOCITY:
        assert axis.velocity == pytest.approx(value, rel=0.02)
    axis.follow(None)
    bench.run(1_000)
    assert abs(axis.velocity) < 1_000, "it stands, position controlled"


@pytest.mark.manual("PD-132")
@pytest.mark.parametrize(
    ("mode", "values"),
    [(Mode.VELOCITY, range(20_000, 2_000_001, 20_000)), (Mode.TORQUE, range(1, 21))],
    ids=lambda value: getattr(value, "name", ""),
)
def test_speeds_and_torques_that_change_reach_the_drive_and_its_states_the_axis(mode: Mode, values: range) -> None:
    bench = Bench("belt").boot().run(2_000).enable("belt")
    axis = bench.axis("belt")
    axis.follow(GivenSetValues(iter(values), mode))
    bench.run(4 * len(values) + 50)
    actual = axis.velocity if mode is Mode.VELOCITY else axis.torque
    assert actual == pytest.approx(values[-1], rel=0.05)


def test_axis_without_set_values_holds_its_place_and_lets_go() -> None:
    bench = Bench("belt").boot().run(2_000).enable("belt")
    axis = bench.axis("belt")
    given = GivenSetValues(iter([]))
    axis.follow(given)
    states: list[AxisState] = []
    axis.watchers.append(lambda: states.append(axis.axis_state))
    bench.set("belt.ControllerEnable", False).run(500)
    assert given.ended == 1
    assert states[-1] is AxisState.WAITING
    assert not axis.is_controlled


@pytest.mark.manual("PD-137")
@pytest.mark.manual("PD-028")
def test_parameters_of_a_drive_take_many_cycles() -> None:
    bench = Bench("belt").boot().run(1_000)
    answers: list[bytes | ServiceError] = []
    bench.axis("belt").read(143, answers.append)
    began_ns = bench.rig.now_ns
    while not answers:
        bench.run(1)
    assert answers == [b"SERCOS II"]
    assert bench.rig.now_ns - began_ns >= 5 * bench.max4.firmware.cycle_ns, "two bytes a cycle"
    bench.set("belt.BrakeDisconnectionTime", 150)
    parameter = bench.max4.firmware.tree.parameter("belt.BrakeDisconnectionTime")
    assert (parameter.value, bench.get("belt.BrakeDisconnectionTime")) == (100, 150), "on its way"
    bench.run(500)
    assert (parameter.value, bench.get("belt.BrakeDisconnectionTime")) == (150, 150)


def test_start_values_are_written_to_the_drive() -> None:
    bench = Bench("belt", parameters={"belt.StopTimeLim": 700}).boot()
    answers: list[bytes | ServiceError] = []
    bench.axis("belt").read(0x8003, answers.append)
    bench.run(200)
    assert answers == [(700).to_bytes(2, "little")]
    assert bench.get("belt.StopTimeLim") == 700


# ---- what goes wrong


@pytest.mark.manual("PD-140")
def test_ring_broken_and_healed_while_axes_move() -> None:
    bench = Bench("belt", "knife").boot().run(2_000).enable("belt", "knife")
    axes = bench.axis("belt"), bench.axis("knife")
    for axis in axes:
        axis.follow(GivenSetValues(count(axis.position, 1_000)))
    bench.run(500)
    assert all(axis.velocity > 200_000 for axis in axes)
    cut = bench.fault("ring0", what="break", after="master")
    bench.run(20)
    assert (bench.get("ring.state"), bench.get("ring.phase")) == ("down", 0)
    assert (bench.get("DiagCode"), bench.get("DiagMsg")) == (2560, "MAX4.MAX4 SERCOS-Ring offen")
    assert [bench.get(f"{name}.DiagCode") for name in ("belt", "knife")] == [2560, 2560]
    assert not any(axis.is_operating or axis.is_enabled for axis in axes)
    assert [(axis.velocity, axis.torque) for axis in axes] == [(0.0, 0)] * 2, "no drive tells them"
    bench.do("quit").run(500)
    assert bench.get("DiagCode") == 2560, "it is still open"
    bench.heal("ring0", cut).run(2_000)
    assert bench.get("ring.state") == "down", "it waits for an acknowledgement"
    bench.do("quit").run(6_000)
    assert (bench.get("ring.state"), bench.get("DiagCode")) == ("up", 0)
    assert [bench.get(f"{name}.DiagCode") for name in ("belt", "knife")] == [0, 0]
    codes = bench.codes()[2:]
    assert codes[0] == 2560
    assert codes.count(2560) == 1
    assert sorted(codes[1:]) == [2112, 2112, 8568]
    bench.enable("belt")
    assert axes[0].is_controlled


@pytest.mark.manual("PD-140")
def test_open_ring_at_boot_is_reported_when_it_was_waited_for() -> None:
    bench = Bench("belt", ring={"faults": [{"what": "off", "station": "belt"}]}, boot={"ring_wait_ms": 500})
    bench.run(499)
    assert bench.codes() == []
    bench.run(200)
    assert bench.codes() == [8002, 2560, 8003]
    assert (bench.get("ring.open"), bench.get("led.bus")) == (True, "off")
    bench.heal("ring0", 1).run(100).do("quit").run(5_000)
    assert (bench.get("ring.state"), bench.get("DiagCode")) == ("up", 0)


def test_cycles_that_a_late_host_missed_are_no_wait_for_the_ring(monkeypatch: pytest.MonkeyPatch) -> None:
    """The processes of the drives are as late as that of the controller, which once reported an open ring."""
    bench = Bench("belt", ring={"faults": [{"what": "off", "station": "belt"}]}, boot={"ring_wait_ms": 500})
    bench.run(100)
    with monkeypatch.context() as host:
        host.setattr(VirtualClock, "late_ns", lambda _: 2_000 * MS)
        bench.run(1)
    assert bench.get("missed_cycles") == 2_000
    bench.run(2_300)
    assert bench.codes() == []
    bench.heal("ring0", 1).boot()
    assert (bench.codes(), bench.get("ring.state")) == ([8002, 8003], "up")


def test_a_ring_that_stays_open_is_reported_by_a_late_host_too(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench("belt", ring={"faults": [{"what": "off", "station": "belt"}]}, boot={"ring_wait_ms": 500})
    with monkeypatch.context() as host:
        host.setattr(VirtualClock, "late_ns", lambda _: 2_000 * MS)
        bench.run(1)
    bench.run(2_600)
    assert bench.codes() == [8002, 2560, 8003]


def test_clock_may_start_at_power_on() -> None:
    bench = Bench("belt", boot={"clock_starts": "power_on"}).run(2)
    assert bench.codes() == [8002]
    assert bench.run(60).codes() == [8002, 8003]
    assert bench.get("ring.state") == "rising"


@pytest.mark.parametrize(("choice", "state"), [("leave_out", "up"), ("stop", "down")])
def test_drive_that_is_not_there_is_left_out_or_stops_the_ring(choice: str, state: str) -> None:
    bench = Bench("belt", more_drives={"knife": {"ring_address": 9}}, missing_drive=choice).boot().run(2_000)
    assert bench.get("ring.state") == state
    assert (bench.get("DiagCode"), bench.get("DiagExtCode")) == (2562, "9.1 2562")
    assert bench.get("DiagMsg") == "MC_4.knife Antrieb antwortet nicht"
    assert bench.codes().count(2562) == 1
    assert bench.axis("belt").is_operating is (state == "up")
    assert not bench.axis("knife").is_operating


def test_an_open_ring_is_one_diagnosis_of_the_controller_and_one_of_each_axis() -> None:
    bench = Bench("belt", "knife").boot().run(1_000)
    bench.fault("ring0", what="break", after="master")
    bench.run(200)
    assert [pending.ext for pending in bench.max4.firmware.diagnosis.pending] == [""]
    assert [bench.axis(name).diagnosis.pending[0].ext for name in ("belt", "knife")] == ["1.1 2560", "2.1 2560"]


def test_drive_whose_telegrams_fail_twice_brings_the_ring_down() -> None:
    bench = Bench("belt", "knife").boot()
    bench.fault("ring0", what="late", station="knife", count=1)
    bench.run(100)
    assert (bench.get("ring.state"), bench.get("knife.ATErrors")) == ("up", 1)
    bench.fault("ring0", what="late", station="knife", count=2)
    bench.run(100)
    assert bench.get("ring.state") == "down"
    assert bench.codes()[-1] == 2561
    assert (bench.get("knife.DiagCode"), bench.get("belt.DiagCode")) == (2561, 0)
    assert bench.max4.troubles() == {"DiagCode": bench.get("DiagCode"), "belt.DiagCode": 0, "knife.DiagCode": 2561}
    bench.do("quit").run(6_000)
    assert (bench.get("ring.state"), bench.get("DiagCode"), bench.get("knife.ATErrors")) == ("up", 0, 3)


@pytest.mark.manual("PD-140")
def test_drive_taken_out_and_put_in_again() -> None:
    """A bypass keeps the ring closed."""
    bench = Bench("belt", "knife", ring={"bypassed": ["knife"]}).boot().run(1_000).enable("belt")
    out = bench.fault("ring0", what="off", station="knife")
    bench.run(200)
    assert (bench.get("ring.state"), bench.get("knife.DiagCode")) == ("down", 2561)
    bench.do("quit").run(3_000)
    assert (bench.get("ring.state"), bench.get("knife.DiagCode")) == ("up", 2562)
    assert bench.axis("belt").is_operating
    bench.heal("ring0", out).enable("belt").run(500)
    bench.do("quit").run(3_000)
    assert not bench.axis("knife").is_operating, "an axis that moves is not stopped for it"
    bench.set("belt.ControllerEnable", False).run(500)
    bench.do("quit").run(5_000)
    assert bench.axis("knife").is_operating
    assert (bench.get("ring.state"), bench.get("DiagCode")) == ("up", 0)


@pytest.mark.manual("PD-332")
@pytest.mark.parametrize(
    ("controller", "drive", "fits"),
    [
        ("V00.15.00", "00.15.09", True),
        ("V00.15.00", "00.07.00", True),
        ("V00.15.09", "00.16.00", False),
        ("V01.15.00", "00.15.00", False),
    ],
)
def test_drive_of_a_version_that_does_not_fit_is_not_operated(controller: str, drive: str, fits: bool) -> None:
    """Acceptance 12."""
    bench = Bench("belt", version=controller, of_drives={"belt": {"versions": {"firmware": drive}}})
    bench.boot().run(2_000).enable("belt")
    assert bench.axis("belt").is_controlled is fits
    assert (bench.get("belt.DiagCode") == 2565) is not fits
    bench.do("quit").run(500)
    assert (bench.get("belt.DiagCode") == 2565) is not fits, "an acknowledgement does not change the version"


@pytest.mark.manual("PD-332")
@pytest.mark.parametrize("fits", [True, False])
def test_drive_gets_no_torque_before_its_version_is_known(fits: bool) -> None:
    """The axis is enabled from the first cycle of operation on, as an IEC program with autostart may do."""
    firmware = "00.15.00" if fits else "01.00.00"
    bench = Bench("belt", "knife", of_drives={"belt": {"versions": {"firmware": firmware}}})
    bench.set("belt.ControllerEnable", True)
    had_torque = was_early = False
    while bench.get("ring.state") != "up" or bench.rig.now_ns < 6_000_000_000:
        bench.run(4).set("belt.ControllerEnable", True)
        had_torque |= bench.drive("belt").machine.chain.has_torque
        was_early |= had_torque and bench.get("ring.state") != "up"
    assert (had_torque, was_early) == (fits, False)
    assert bench.axis("belt").is_controlled is fits
    assert bench.get("belt.DiagCode") == (0 if fits else 2565)


def test_telegrams_that_do_not_fit_into_the_cycle_are_reported() -> None:
    names = [f"d{number}" for number in range(12)]
    bench = Bench(*names, cycle_ms=1).boot().run(100)
    assert (bench.get("ring.state"), bench.get("DiagCode")) == ("down", 2564)


def test_set_values_are_as_many_as_the_cycle_has_room_for() -> None:
    few = Bench("belt", cycle_ms=1).boot()
    assert few.axis("belt").modes == set(Mode)
    many = Bench(*[f"d{number}" for number in range(9)], cycle_ms=1).boot()
    assert many.get("ring.state") == "up"
    assert many.axis("d1").modes == {Mode.POSITION}
    many.axis("d1").follow(GivenSetValues(iter([1.0]), Mode.TORQUE))
    many.run(2_000).enable("d1")
    assert (many.axis("d1").mode, many.axis("d1").velocity) == (Mode.POSITION, 0.0), "it stands"


@pytest.mark.manual("PD-002")
@pytest.mark.parametrize("count", [40, 44, 47])
def test_as_many_axes_as_the_manual_names_move_at_4_ms(count: int) -> None:
    """The manual gives 40, 44 and 47 (digest X1).  From 44 axes up, velocities do not fit into the ATs."""
    names = [f"d{number}" for number in range(count)]
    bench = Bench(*names, max_axes=47).boot().run(4_000)
    assert (bench.get("ring.state"), bench.get("DiagCode")) == ("up", 0)
    bench.enable(*names)
    axes = [bench.axis(name) for name in names]
    for axis in axes:
        axis.follow(GivenSetValues(iter(range(1_000, 400_000, 1_000))))
    bench.run(1_000)
    assert all(axis.velocity == pytest.approx(250_000, rel=0.002) for axis in axes)
    assert int(bench.get("RTBWriteRes")) > 0
    bench.run(1_500)
    assert [axis.position for axis in axes] == pytest.approx([399_000] * count, abs=2)
    assert all(abs(axis.velocity) < 1_000 for axis in axes)
    assert (bench.get("ring.state"), bench.get("DiagCode")) == ("up", 0)


# ---- what it takes of a cycle


@pytest.mark.manual("PD-084")
def test_real_time_process_sees_to_all_that_the_manual_names_without_a_task() -> None:
    """Logic and master encoders, motion tasks with set values, measuring inputs, and the exchange over the ring."""
    bench = Bench(
        "belt",
        logic_encoders=["Virtual"],
        master_encoders={"Line": "line.encoder"},
        measuring_inputs={"Probe": "probe.1"},
    ).boot()
    bench.run(2_000).enable("belt")
    assert not bench.max4.firmware.plc.is_running
    asked: list[float] = []

    def path() -> Iterator[int]:
        for place in itertools.count():
            asked.append(bench.max4.firmware.system.process.master_encoders[0].position)
            yield 1_000 * place

    bench.axis("belt").follow(GivenSetValues(path()))
    bench.set("Virtual.Velocity", 250.0)
    begin = int(bench.get("cycles"))
    wires = bench.rig.attach("line").link("wires")
    wires.send(Motion("line.encoder", 0.0, "count", bench.rig.now_ns, 500.0))
    bench.run(400)
    cycles = int(bench.get("cycles")) - begin
    assert cycles == 100
    assert bench.get("Virtual.Position") == pytest.approx(cycles * 0.004 * 250)
    assert len(asked) == pytest.approx(cycles, abs=1)
    steps = {round(after - before, 6) for before, after in itertools.pairwise(asked[2:])}
    assert steps == {2.0}, "500 a second, sampled in each cycle"
    wires.send(Signal("probe.1", True))
    bench.run(20)
    assert bench.get("Probe.Count") == 1
    assert float(bench.get("Probe.Position_belt")) == pytest.approx(bench.axis("belt").position, abs=12_000)
    assert bench.axis("belt").velocity == pytest.approx(250_000, rel=0.01)


@pytest.mark.manual("PD-084")
@pytest.mark.manual("PD-085")
@pytest.mark.manual("PD-134")
def test_reserves_come_from_the_timing_of_the_ring() -> None:
    small, large = Bench("belt", cycle_ms=1).boot(), Bench("belt", "knife", cycle_ms=1).boot()
    read, write = int(large.get("RTBReadRes")), int(large.get("RTBWriteRes"))
    assert 0 < write < read < int(small.get("RTBReadRes")) < 1_000
    assert large.get("CycleLoad") == (60 + 2 * 12) * 100 // 1_000
    for more_us, load in ((505, 58), (2_000, 100)):  # 589 us of a cycle of 1000
        number = large.fault("max4", what="overrun", us=more_us)
        assert large.run(5).get("CycleLoad") == load
        large.heal("max4", number)


@pytest.mark.manual("PD-134")
def test_process_that_takes_too_long_is_a_write_overflow() -> None:
    bench = Bench("belt", cycle_ms=1).boot()
    assert (bench.get("DiagCode"), bench.codes().count(6507)) == (0, 0)
    long = bench.fault("max4", what="overrun", us=1_000)
    bench.run(100)
    assert int(bench.get("RTBWriteRes")) < 0
    assert bench.get("DiagCode") == 6507
    assert bench.codes().count(6507) == 1
    bench.heal("max4", long).run(10)
    assert int(bench.get("RTBWriteRes")) > 0
    assert bench.do("quit").run(10).get("DiagCode") == 0
    assert bench.codes().count(6507) == 1
    reserve = int(bench.get("RTBWriteRes"))
    for more_us, entries in ((reserve, 1), (reserve + 1, 2)):  # it has to be below zero
        number = bench.fault("max4", what="overrun", us=more_us)
        assert bench.run(10).codes().count(6507) == entries
        bench.heal("max4", number)


@pytest.mark.parametrize("how", ["system reset", "power_off"])
def test_a_fault_that_makes_the_process_longer_outlasts_a_boot(how: str) -> None:
    bench = Bench("belt").boot()
    bench.fault("max4", what="overrun", us=1_000)
    reserve = bench.run(100).get("RTBWriteRes")
    if how == "power_off":
        number = bench.fault("max4", what="power_off")
        bench.run(5).heal("max4", number)
    else:
        bench.do(how)
    assert bench.boot().get("RTBWriteRes") == reserve


class LateClock(VirtualClock):
    """The clock of a host that is late by five cycles."""

    def late_ns(self) -> int:
        return 5 * MS


def test_a_host_that_is_late_is_no_load_of_the_controller() -> None:
    """Entries with 6507 once filled the message logger of a controller that was idle, on a busy host."""
    overflows: list[int] = []
    on_time, late = [
        RealTimeProcess(clock, MS, ProcessTimes(), overflows.append) for clock in (VirtualClock(), LateClock())
    ]
    for process in (on_time, late):
        process.run()
    assert overflows == []
    assert late.load_percent == on_time.load_percent
    assert (late.read_reserve_us, late.write_reserve_us) == (on_time.read_reserve_us, on_time.write_reserve_us)


def test_process_goes_on_without_a_ring() -> None:
    bench = Bench("belt").boot()
    asked: list[int] = []
    bench.max4.firmware.each_cycle(lambda: asked.append(bench.max4.firmware.cycle_ns))
    bench.fault("ring0", what="break", after="master")
    bench.run(100)
    asked.clear()
    bench.run(400)
    assert len(asked) == 100


def test_faces_hear_of_each_boot() -> None:
    bench = Bench("belt").boot()
    boots: list[list[str]] = []
    bench.max4.firmware.on_boot(lambda: boots.append(list(bench.max4.firmware.axes)))
    bench.do("add encoder M").do("system reset").boot()
    assert boots == [["belt"]]


def test_the_controller_is_what_faces_are_given() -> None:
    bench = Bench("belt").boot()
    controller: Controller = bench.max4.firmware
    axis = controller.axes["belt"]
    given: SetValues = GivenSetValues(iter([]))
    axis.follow(given)
    assert controller.is_booted
    section = controller.section("can0")
    section.save(b"objects of a node")
    assert controller.section("can0").load() == b"objects of a node"
    assert "can0" not in str(bench.get("files")).lower()


@pytest.mark.manual("PD-155")
def test_a_stop_time_limit_behind_another_error_is_in_the_log_without_further_effect() -> None:
    """6127-6134: the message is triggered; the DiagCode stays that of the first error of the class (4180)."""
    heavy = {"load": {"inertia_kg_m2": 0.05}, "parameters": {"stop_time_limit_ms": 50}}
    bench = Bench("belt", of_drives={"belt": heavy}).boot().run(5_000).enable("belt")
    accelerating = accumulate(min(150 * cycle, 66_666) for cycle in count())  # to 1000 1/min
    start = bench.max4.firmware.axes["belt"].position
    bench.max4.firmware.axes["belt"].follow(GivenSetValues((float(start + way) for way in accelerating), Mode.POSITION))
    bench.run(3_000)
    before = len(bench.codes())
    bench.fault("belt", what="dc_bus", sort="communication")
    bench.run(2_000)
    assert bench.codes()[before:] == [2106, 2190]
    assert bench.get("belt.DiagCode") == 2106
    assert bench.rig.get("belt", "diag_code") == 2106
