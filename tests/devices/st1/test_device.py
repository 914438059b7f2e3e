"""The ST1 as a device: on a ring with a PAM's end, on wires, its registers, points and faults."""

import pytest
from device_of import device_of
from st1_device_bench import DeviceBench

from fieldrig.clock import MS
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.pamring.axis_words import Error, Status
from fieldrig_devices.pamring.frames import (
    Answer,
    AxisOrder,
    AxisReport,
    InputChanged,
    Move,
    Read,
    SetOutput,
    SetPoint,
    SetPointMode,
)
from fieldrig_devices.pamring.registers import Parameter, Variable
from fieldrig_devices.st1.device import St1
from fieldrig_devices.st1.shaft import TURN

BANK = 0x100


@pytest.fixture
def bench() -> DeviceBench:
    return DeviceBench()


def test_an_axis_moves_over_the_ring(bench: DeviceBench) -> None:
    bench.send(AxisOrder(1, Move.POWER_ON))
    bench.send(AxisOrder(2, Move.ABSOLUTE_MOVE, 3 * TURN, 10 * TURN, 100 * TURN, 100 * TURN)).run(600)
    assert bench.take(AxisReport)[-1] == AxisReport(Status.STOPPED, 0, 2, 3 * TURN)
    assert (bench.get("position"), bench.get("speed"), bench.get("power"), bench.get("order")) == (3.0, 0.0, True, 2)


def test_the_position_is_a_motion_on_a_wire(bench: DeviceBench) -> None:
    bench.send(AxisOrder(1, Move.POWER_ON)).run(5)
    bench.wires.clear()
    bench.send(AxisOrder(2, Move.ABSOLUTE_MOVE, 3 * TURN, 10 * TURN, 100 * TURN, 100 * TURN)).run(600)
    motions = [(ns, motion) for ns, motion in bench.wires if isinstance(motion, Motion)]
    tau = 6.283185307179586
    assert [motion.acceleration / tau for _, motion in motions] == pytest.approx([100.0, 0.0, -100.0, 0.0])
    assert [(ns - motions[0][0]) / MS for ns, _ in motions] == pytest.approx([0, 100, 300, 400], abs=1e-3)
    assert motions[-1][1].value == pytest.approx(3 * tau)
    assert all(ns == motion.time_ns for ns, motion in motions)


def test_the_terminals_are_wires(bench: DeviceBench) -> None:
    assert bench.take(InputChanged) == [InputChanged(1, 0)]
    bench.drive("IN0", True).run(5)
    assert [(change.item, change.value) for change in bench.take(InputChanged)] == [(1, 1)]
    bench.wires.clear()
    bench.send(SetOutput(2, 1)).run(5)
    assert [signal for _, signal in bench.wires] == [Signal("axis.OUT8", True)]
    assert bench.get("OUT8") is True


@pytest.mark.manual("PAML-144")
def test_a_read_is_answered_in_its_cycle(bench: DeviceBench) -> None:
    bench.pam.reports.clear()
    bench.send(Read(1, 0)).send(Read(2, 5)).run(3)  # a cycle to the node, and one back
    assert bench.take(Answer) == [Answer(1, 0), Answer(2, None)]


@pytest.mark.manual("PAML-140", "PAML-141")
def test_the_registers_of_positions(bench: DeviceBench) -> None:
    bench.send(AxisOrder(1, Move.POWER_ON))
    bench.send(AxisOrder(2, Move.RELATIVE_MOVE, 5 * TURN // 2, 10 * TURN)).run(600)
    assert bench.read(0) == bench.read(2) == 5 * 65536 // 2  # 2^16 counts a turn
    assert bench.read(Variable.PHIRE + 3 * BANK) == 5 * 65536 // 2
    assert bench.read(Variable.PHIRE + BANK) == -32768  # half a turn, in 16 bits
    bench.drive("second", 1.5, "turn").drive("incremental", -1234.0, "count").drive("analog", -5.0, "V")
    assert (bench.read(1), bench.read(3), bench.read(4)) == (98304, -1234, -16384)


@pytest.mark.manual("PAML-146")
def test_a_position_rolls_over() -> None:
    bench = DeviceBench(initial_turns=32767.5)
    bench.send(AxisOrder(1, Move.POWER_ON))
    bench.send(AxisOrder(2, Move.RELATIVE_MOVE, TURN, 10 * TURN)).run(600)
    assert bench.read(0) == -(1 << 31) + 32768


@pytest.mark.manual("PAML-149")
def test_the_temperature_of_the_manual_s_example(bench: DeviceBench) -> None:
    bench.drive("motor_temperature", 45.5, "degC")
    assert bench.read(1273) == 728  # PULSES_PER_UNIT = 16.0


@pytest.mark.manual("PAMS-110")
@pytest.mark.parametrize(
    ("address", "value"), [(0xB4, 0x0F), (0xB2, 0x0001 - 0x8000), (0xB3, 0x0003)], ids=["CACOUT", "CACTIN", "CVALIN"]
)
def test_the_parameters_of_the_boards(address: int, value: int) -> None:
    bench = DeviceBench(parameters={"cacout": 0x0F, "cactin": 0x8001, "cvalin": 0x0003})
    assert bench.read(0x400 + address) == value


@pytest.mark.manual("PAMS-110")
def test_local_actions_see_the_inputs_of_cvalin_with_the_levels_of_cactin() -> None:
    bench = DeviceBench(parameters={"cactin": 0x0001, "cvalin": 0x0007})
    bench.drive("IN16", True).drive("IN17", True).drive("IN20", True)
    assert bench.read(Variable.INPUTS) == 0b101  # IN 16 is high, IN 17 is high, IN 18 is low


@pytest.mark.manual("PAML-140", "PAML-163")
def test_the_parameters_that_grouped_axes_share() -> None:
    bench = DeviceBench(parameters={"ckv": 25.0, "cka": 400.0, "ckr": 3, "ckh": -4, "equip": 0xC000})
    codes = [Parameter.CKV, Parameter.CKA, Parameter.CKR, Parameter.CKH, Parameter.EQUIP]
    expected = [25 * 65536, 400 * 65536, 3, -4, 0xC000]
    assert [bench.read(0x600 + code) for code in codes] == expected


@pytest.mark.manual("PAML-140")
def test_the_other_variables(bench: DeviceBench) -> None:
    bench.send(AxisOrder(1, Move.POWER_ON))
    bench.send(AxisOrder(2, Move.RUN, 2 * TURN)).run(100)
    bench.send(SetOutput(2, 1)).drive("supply", 300.0, "V")
    wide = {Variable.SPEED: 131072, Variable.SET_SPEED: 131072, Variable.LAG: 0, Variable.TORQUE_LIMIT: 1000}
    narrow = {Variable.OUTPUTS: 1, Variable.SUPPLY: 300, Variable.STATUS_AB: 0, Variable.STATUS_CD: 0}
    for code, value in (wide | narrow).items():
        assert bench.read(0x200 + code) == value, code


def test_a_register_that_is_not_there(bench: DeviceBench) -> None:
    assert [bench.read(register) for register in (5, 26, 256, 255, 2048)] == [None] * 5


def test_registers_of_the_rig_file() -> None:
    bench = DeviceBench(
        variables={200: {"value": 5}}, further_parameters={201: {"value": 0, "wire": "axis.hall", "scale": 10.0}}
    )
    assert bench.read(200) == 5
    bench.rig.set("axis", "variables/200", 70000)
    assert (bench.read(200), bench.read(0x200 + 200)) == (4464, 70000)
    bench.drive("hall", 1.5)
    assert bench.read(0x400 + 201) == 15
    assert bench.get("parameters/201") == 15


@pytest.mark.manual("PAMS-049")
@pytest.mark.parametrize(
    ("wire", "value", "bit"),
    [
        ("supply", 401.0, Error.OVER_VOLTAGE),
        ("supply", 99.0, Error.INT_SUPPLY_FAILURE),
        ("auxiliary", False, Error.AUX_SUPPLY_FAILURE),
        ("motor_temperature", 121.0, Error.MOTOR_TEMPERATURE),
        ("enable", False, Error.POWER_STAGE_DISABLED),
    ],
)
def test_wires_and_points_make_errors(wire: str, value: float, bit: Error) -> None:
    by_wire, by_point = DeviceBench(supply={"lowest_v": 100.0}), DeviceBench(supply={"lowest_v": 100.0})
    by_wire.drive(wire, value)
    by_point.rig.set("axis", wire, value)
    for bench in (by_wire, by_point):
        assert bench.run(5).take(AxisReport)[-1].error & ~Error.CHANGE_IN_CD == bit
        assert str(bit.name) in str(bench.get("errors"))


def test_a_load_slows_the_axis(bench: DeviceBench) -> None:
    bench.drive("load_torque", 19.0, "N m")
    bench.send(AxisOrder(1, Move.POWER_ON)).send(AxisOrder(2, Move.RUN, 10 * TURN)).run(50)
    assert float(bench.get("lag")) > 0.1
    assert bench.get("load_torque") == 19.0


@pytest.mark.parametrize("value", [1e308, -1e308, 5e-324])
def test_a_wire_takes_any_number(bench: DeviceBench, value: float) -> None:
    for wire in ("load_torque", "motor_temperature", "supply", "analog", "second", "incremental", "IN0", "enable"):
        bench.drive(wire, value)
    bench.run(5)
    assert all(bench.read(register) is not None for register in (1, 3, 4, 1273, Variable.SUPPLY))


def test_a_fault_of_the_rig_file_and_one_at_run_time() -> None:
    bench = DeviceBench(faults=[{"what": "resolver", "duration_ms": 50}])
    assert bench.take(AxisReport)[-1].error == 0
    bench.rig.add_fault("axis", {"what": "overload"})
    assert bench.run(5).take(AxisReport)[-1].error == Error.POWER_STAGE_OVERLOAD


@pytest.mark.manual("PAMS-108")
def test_a_broken_ring_stops_the_axis(bench: DeviceBench) -> None:
    bench.send(AxisOrder(1, Move.POWER_ON)).send(AxisOrder(2, Move.RUN, 10 * TURN)).run(100)
    bench.rig.add_fault("ring0", {"what": "break", "after": "axis"})
    bench.run(200)  # the PAM stops, so the node in front of the break hears nothing
    assert (bench.get("speed"), bench.get("power"), bench.get("ring")) == (0.0, False, "inactive")
    again = DeviceBench()
    again.send(AxisOrder(1, Move.POWER_ON)).send(AxisOrder(2, Move.RUN, 10 * TURN)).run(100)
    again.rig.add_fault("ring0", {"what": "break", "after": "pam"})
    again.run(200)
    assert (again.get("speed"), again.get("power"), again.get("ring")) == (0.0, False, "carrier")
    assert again.get("errors") == "CHANGE_IN_CD COMMUNICATION_FAILURE"


@pytest.mark.manual("PAMS-108")
@pytest.mark.parametrize(("inactive_ms", "seen"), [(50, ["none", "inactive"]), (200, ["none", "none"])])
def test_the_time_until_the_ring_is_inactive_is_a_setting(inactive_ms: int, seen: list[str]) -> None:
    bench = DeviceBench(ring_inactive_ms=inactive_ms)
    bench.rig.add_fault("ring0", {"what": "break", "after": "axis"})
    found = []
    for _ in range(2):
        bench.run(45)
        found.append(bench.get("ring"))
    assert found == seen
    bench.run(200)
    assert bench.get("ring") == "inactive"
    assert device_of(bench.rig, "axis", St1).troubles()["ring"] == "inactive"


def torques(bench: DeviceBench, *instants_ms: int) -> list[float]:
    """Return the torque at these times after now."""
    begin_ns = bench.rig.now_ns
    found = []
    for ms in instants_ms:
        bench.rig.run_until(begin_ns + ms * MS)
        found.append(float(bench.get("torque")))
    return found


def test_the_torque_accelerates_overcomes_friction_and_brakes(bench: DeviceBench) -> None:
    """100 turns/s2 of 0.002 kg m2 are 1.257 N m; friction and load take 0.5 and 0.3 N m in each direction."""
    bench.send(AxisOrder(1, Move.POWER_ON)).run(5)
    bench.rig.set("axis", "load_torque", 0.3)
    assert bench.get("torque") == 0
    rate_nm = 0.002 * 100 * 6.283185307179586
    bench.send(AxisOrder(2, Move.ABSOLUTE_MOVE, 3 * TURN, 10 * TURN, 100 * TURN, 100 * TURN))
    assert torques(bench, 50, 200, 350, 600) == pytest.approx([rate_nm + 0.8, 0.8, 0.8 - rate_nm, 0.0])
    bench.send(AxisOrder(3, Move.ABSOLUTE_MOVE, 0, 10 * TURN, 100 * TURN, 100 * TURN))
    assert torques(bench, 50, 200, 350, 600) == pytest.approx([-rate_nm - 0.8, -0.8, rate_nm - 0.8, 0.0])


def test_a_jammed_motor_pushes_with_all_of_its_torque_until_it_has_no_power() -> None:
    bench = DeviceBench(lag_limit_turns=1000)
    bench.send(AxisOrder(1, Move.POWER_ON)).run(5)
    bench.rig.add_fault("axis", {"what": "jam"})
    bench.send(AxisOrder(2, Move.ABSOLUTE_MOVE, -3 * TURN, 10 * TURN, 100 * TURN, 100 * TURN))
    assert torques(bench, 50) == pytest.approx([-20.0])
    bench.send(SetPoint(SetPointMode.TORQUE, 250))
    assert torques(bench, 5) == pytest.approx([-5.0])
    bench.rig.set("axis", "enable", False)
    assert torques(bench, 5) == [0.0]
