"""An ST1 whose motor is a plant on wires: the loop of torque and encoder, and what a load or a jam does."""

import pytest
from st1_device_bench import DeviceBench

from fieldrig_devices.pamring.axis_words import Error
from fieldrig_devices.pamring.frames import AxisOrder, AxisReport, Move, SetPoint, SetPointMode
from fieldrig_devices.st1.shaft import TURN

MOTOR = {
    "kind": "plant.servo", "links": {"wires": "wires"}, "reference_wire": "axis.reference", "rated_torque_nm": 20.0,
    "motor_inertia_kg_m2": 0.002, "coulomb_nm": 0.2, "encoder_lines": 2500,
}  # fmt: skip
PLANT = {"encoder_wire": "motor.encoder", "counts_per_turn": 10000.0}


@pytest.fixture
def bench() -> DeviceBench:
    bench = DeviceBench(more={"motor": MOTOR}, plant=PLANT)
    bench.send(AxisOrder(1, Move.POWER_ON)).run(50)
    return bench


def move(number: int, turns: int) -> AxisOrder:
    return AxisOrder(number, Move.ABSOLUTE_MOVE, turns * TURN, 10 * TURN, 200 * TURN, 200 * TURN)


@pytest.mark.long
def test_the_motor_follows_the_set_position(bench: DeviceBench) -> None:
    bench.send(move(2, 3))
    lags = [abs(float(bench.run(1).get("lag"))) for _ in range(400)]
    assert max(lags) < 0.02
    bench.run(600)
    assert float(bench.get("position")) == pytest.approx(3.0, abs=2e-4)
    assert float(bench.rig.get("motor", "position")) == pytest.approx(3 * 6.283185307179586, abs=1e-3)
    assert bench.take(AxisReport)[-1].error == 0


@pytest.mark.long
def test_the_motor_follows_a_pipe(bench: DeviceBench) -> None:
    lags = []
    for cycle in range(400):
        way = 50e-6 * cycle * cycle if cycle < 100 else 0.5 + 0.01 * (cycle - 100)  # 100 turns/s2 up to 10 turns/s
        bench.send(SetPoint(SetPointMode.POSITION, round(way * TURN))).run(1)
        lags.append(abs(float(bench.get("lag"))))
    assert max(lags) < 0.05
    assert lags[-1] < 0.01
    assert float(bench.rig.get("motor", "speed")) == pytest.approx(10 * 6.283185307179586, rel=0.02)


@pytest.mark.long
def test_the_loop_rests_with_the_motor(bench: DeviceBench) -> None:
    bench.send(move(2, 1)).run(2000)
    bench.wires.clear()
    bench.run(1000)
    assert bench.wires == []
    bench.rig.set("motor", "load_torque", -6.0)
    bench.run(1000)
    assert bench.wires
    assert float(bench.get("position")) == pytest.approx(1.0, abs=2e-4)


def test_a_jammed_motor_gives_a_lag_error(bench: DeviceBench) -> None:
    bench.rig.set("motor", "blocked", True)
    bench.send(move(2, 3)).run(60)
    assert "CURRENT_LIMITED" in str(bench.get("errors"))
    bench.run(200)
    assert bench.take(AxisReport)[-1].error & Error.SERVO_LAG_ERROR
    assert bench.get("power") is False
    assert bench.rig.get("motor", "reference") == 0.0


@pytest.mark.long
def test_a_motor_without_power_is_where_its_load_takes_it(bench: DeviceBench) -> None:
    bench.send(AxisOrder(2, Move.POWER_OFF)).run(50)
    bench.rig.set("motor", "load_torque", -1.0)
    bench.run(500)
    assert float(bench.get("position")) == pytest.approx(float(bench.get("motor")), abs=1e-3)
    assert float(bench.get("motor")) > 1.0
    bench.rig.set("motor", "load_torque", 0.0)
    bench.send(AxisOrder(3, Move.POWER_ON)).run(2000)
    assert float(bench.get("position")) == pytest.approx(0.0, abs=5e-4)


@pytest.mark.long
def test_the_torque_is_what_the_loop_asks_of_a_motor_on_wires(bench: DeviceBench) -> None:
    bench.send(move(2, 1)).run(2000)
    bench.rig.set("motor", "load_torque", -6.0)
    bench.run(1000)
    assert float(bench.get("torque")) == pytest.approx(-6.2, abs=0.1)  # a positive load acts backwards
    bench.rig.set("axis", "enable", False)
    assert bench.run(5).get("torque") == 0
