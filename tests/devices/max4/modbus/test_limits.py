"""Limits of an axis that a Modbus client moves: switches at -300 and 400 units, software limits at -250 and 350."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, Self

import pytest
from max4_faces_bench import FacesBench, Type

from fieldrig.errors import ConfigError
from fieldrig_bus.wires import Signal

BELT, UNIT = 1000, 1000
ENABLE, OPERATION, TARGET, SPEED, VELOCITY, TORQUE, COMMAND, MIN, MAX, STATUS = 0, 1, 2, 4, 10, 12, 13, 14, 16, 23
START, START_RELATIVE, STOP, FORWARD, BACKWARD = 1, 2, 3, 4, 5
MOVING, REACHED, NEGATIVE, POSITIVE, LIMITED = 0x08, 0x10, 0x100, 0x200, 0x400
SHOWN = MOVING | REACHED | NEGATIVE | POSITIVE | LIMITED
SWITCHES = {"belt.neg": -300 * UNIT, "belt.pos": 400 * UNIT}
STOPPING = 1000 * 1000 // (2 * 10_000) + 12
"""Units that a stop from 1000 units a second takes, and the cycles in which the switch is seen."""
PLATE = str(Path(__file__).parents[4] / "configs" / "plates" / "sm-100-30-080.yaml")


class LimitBench(FacesBench):
    """Its switches are on wires: on while the axis is beyond them, unless a test says otherwise."""

    def __init__(self, limits: dict[str, Any] | None = None, **settings: Any) -> None:
        switches = {"negative_limit": "I_bNeg", "positive_limit": "I_bPos"}
        self.is_on: dict[str, Callable[[int], bool]] = {
            "belt.neg": lambda position: position <= SWITCHES["belt.neg"],
            "belt.pos": lambda position: position >= SWITCHES["belt.pos"],
        }
        self._shown: dict[str, bool] = {}
        modbus = {"limits": {"belt": switches if limits is None else limits}}
        super().__init__(**{"modbus": modbus, **settings}, inputs={"I_bNeg": "belt.neg", "I_bPos": "belt.pos"})

    def run(self, ms: float) -> "LimitBench":
        for _ in range(round(ms)):
            super().run(1)
            if "belt" in self.max4.firmware.axes:
                self._switch(self.axis("belt").position)
        return self

    def _switch(self, position: int) -> None:
        for name, is_on in self.is_on.items():
            if self._shown.get(name) is not is_on(position):
                self._shown[name] = is_on(position)
                self.outside.link("wires").send(Signal(name, self._shown[name]))

    def ready(self) -> Self:
        self.boot(10_000 if "mc" in self.rig.config.devices else 100)
        self.write(BELT + ENABLE, 1)
        self.run(500)
        return self

    def order(self, command: int, ms: float = 1_500, **values: int) -> "LimitBench":
        for name, value in values.items():
            offset, type = {
                "operation": (OPERATION, Type.UINT16),
                "target": (TARGET, Type.INT32),
                "velocity": (VELOCITY, Type.INT32),
                "torque": (TORQUE, Type.INT16),
                "lowest": (MIN, Type.INT32),
                "highest": (MAX, Type.INT32),
            }[name]
            assert self.write(BELT + offset, value, type) == 0
        assert self.write(BELT + COMMAND, command) == 0
        return self.run(ms)

    @property
    def place(self) -> float:
        return self.axis("belt").position / UNIT

    @property
    def status(self) -> int:
        value: int = self.read(BELT + STATUS)
        return value & SHOWN


@pytest.fixture
def bench() -> LimitBench:
    return LimitBench().ready()


# What moves an axis in a direction, with 1000 units a second.
ORDERS: dict[str, Callable[[LimitBench, int], object]] = {
    "to a place": lambda bench, direction: bench.order(START, operation=0, target=direction * 900),
    "by a way": lambda bench, direction: bench.order(START_RELATIVE, target=direction * 900),
    "at a speed": lambda bench, direction: bench.order(START, operation=1, velocity=direction * 1000),
    "jogging": lambda bench, direction: bench.order(FORWARD if direction > 0 else BACKWARD),
}


@pytest.mark.parametrize("how", ORDERS)
@pytest.mark.parametrize(("direction", "switch", "bit"), [(-1, -300, NEGATIVE), (1, 400, POSITIVE)])
def test_an_axis_stops_at_the_limit_switch_stays_there_and_comes_out_again(
    bench: LimitBench, how: str, direction: int, switch: int, bit: int
) -> None:
    assert bench.status == 0
    ORDERS[how](bench, direction)
    assert switch * direction <= bench.place * direction <= switch * direction + STOPPING
    assert (bench.axis("belt").velocity, bench.status) == (0, bit | LIMITED)
    stands = bench.place
    ORDERS[how](bench, direction)
    assert (bench.place, bench.status) == (stands, bit | LIMITED)
    bench.order(BACKWARD if direction > 0 else FORWARD, ms=300)
    assert bench.axis("belt").velocity == -direction * 1000 * UNIT
    assert bench.status == MOVING | REACHED


def test_a_switch_that_was_overrun_still_bars_the_direction(bench: LimitBench) -> None:
    bench.is_on["belt.pos"] = lambda position: 400 * UNIT <= position <= 410 * UNIT
    bench.order(FORWARD)
    stands = bench.place
    assert stands > 410
    assert bench.status == LIMITED
    bench.order(STOP)
    bench.order(FORWARD)
    assert bench.place == stands
    bench.order(BACKWARD, ms=300)
    bench.order(FORWARD, ms=100)
    assert bench.status == MOVING


def test_the_way_is_braked_with_the_deceleration_of_the_order(bench: LimitBench) -> None:
    bench.order(FORWARD, ms=0)
    places: list[int] = []
    bench.max4.firmware.each_cycle(lambda: places.append(bench.axis("belt").position))
    bench.run(1_500)
    speeds = [(after - before) / 0.004 for before, after in pairwise(places)]
    top = max(range(len(speeds)), key=lambda cycle: (speeds[cycle], cycle))
    falls = [before - after for before, after in pairwise(speeds[top + 2 :]) if after > 0]
    assert len(falls) > 20
    assert falls == pytest.approx([10_000 * UNIT * 0.004] * len(falls), rel=0.02)


def test_an_axis_that_is_on_a_switch_when_it_is_enabled_only_goes_out(bench: LimitBench) -> None:
    bench.order(FORWARD)
    bench.write(BELT + ENABLE, 0)
    bench.run(50)
    assert bench.status == POSITIVE
    bench.write(BELT + ENABLE, 1)
    bench.run(300)
    stands = bench.place
    bench.order(START, operation=0, target=1_000)
    assert (bench.place, bench.status) == (stands, POSITIVE | LIMITED)
    bench.order(START, operation=0, target=0)
    assert (bench.place, bench.status) == (0, REACHED)


def test_switches_of_the_can_axes_hold_for_modbus_too() -> None:
    terminals = {"belt": {"negative_limit": "I_bNeg", "positive_limit": "I_bPos"}}
    bench = LimitBench(modbus={}, can_axes={"node_ids": [10], "terminals": terminals}).ready()
    bench.order(FORWARD)
    assert (bench.status, bench.axis("belt").velocity) == (POSITIVE | LIMITED, 0)


class TorqueBench(LimitBench):
    """A torque of 10 % for a second, up to a limit."""

    def push(self, **limits: int) -> float:
        """How far it went at most until it could stop, from where the limit was seen."""
        speeds: list[float] = []
        self.max4.firmware.each_cycle(lambda: speeds.append(self.axis("belt").velocity / UNIT))
        self.order(START, ms=1_000, operation=2, torque=100, **limits)
        assert abs(speeds[-1]) < 10
        return max(speeds) ** 2 / (2 * 10_000) + max(speeds) * 0.020


def torque_bench() -> TorqueBench:
    motor = {
        "kind": "mc4",
        "ring_address": 1,
        "motor": {"name_plate": PLATE},
        "links": {"ring": "ring"},
        "load": {"inertia_kg_m2": 0.01},
    }
    return TorqueBench(
        buses={"ring": {"kind": "ring.virtual"}}, devices={"mc": motor}, drives={"belt": {"ring_address": 1}}
    ).ready()


@pytest.mark.long
def test_a_torque_is_taken_away_at_a_switch_and_the_other_way_gives_one_again() -> None:
    bench = torque_bench()
    assert SWITCHES["belt.neg"] < bench.axis("belt").position < SWITCHES["belt.pos"]
    stopping = bench.push()
    assert bench.status == POSITIVE | LIMITED
    stands = bench.place
    assert 400 < stands < 400 + stopping
    bench.order(START, ms=500)
    assert bench.place == pytest.approx(stands, abs=1)
    bench.order(START, ms=200, torque=-100)
    assert bench.place < stands - 1
    assert bench.status & (MOVING | LIMITED) == MOVING


@pytest.mark.long
def test_a_torque_ends_at_a_software_limit_too() -> None:
    bench = torque_bench()
    stopping = bench.push(lowest=-250, highest=350)
    assert bench.status & LIMITED
    assert 350 < bench.place < 350 + stopping


@pytest.mark.parametrize(("target", "place", "bits"), [(900, 350, LIMITED), (-900, -250, LIMITED), (300, 300, 0)])
@pytest.mark.parametrize("command", [START, START_RELATIVE])
def test_a_target_behind_a_software_limit_is_at_the_limit(
    bench: LimitBench, command: int, target: int, place: int, bits: int
) -> None:
    bench.order(command, target=target, lowest=-250, highest=350)
    assert (bench.place, bench.status) == (place, REACHED | bits)


@pytest.mark.parametrize(("command", "place"), [(FORWARD, 350), (BACKWARD, -250)])
def test_a_speed_ends_at_a_software_limit(bench: LimitBench, command: int, place: int) -> None:
    places: list[float] = []
    bench.max4.firmware.each_cycle(lambda: places.append(bench.place))
    bench.order(command, lowest=-250, highest=350)
    assert (bench.place, bench.status) == (place, LIMITED)
    bench.order(command)
    assert (bench.place, bench.status) == (place, LIMITED)
    assert max(abs(place) for place in places) == abs(place)
    bench.order(FORWARD + BACKWARD - command, ms=200)
    assert bench.status & (MOVING | LIMITED) == MOVING


def test_an_axis_beyond_its_software_limits_comes_back(bench: LimitBench) -> None:
    bench.order(START, target=380)
    assert bench.status == REACHED
    bench.order(START, target=390, lowest=-250, highest=350)
    assert (bench.place, bench.status) == (350, REACHED | LIMITED)


@pytest.mark.parametrize(("lowest", "highest"), [(0, 0), (100, -100), (-(2**31), 2**31 - 1)])
def test_limits_are_none_where_the_lower_one_is_not_below(bench: LimitBench, lowest: int, highest: int) -> None:
    bench.order(START, target=380, lowest=lowest, highest=highest)
    assert (bench.place, bench.status) == (380, REACHED)


def test_software_limits_have_their_start_values_in_the_rig_file() -> None:
    bench = LimitBench({"min_position": -250, "max_position": 350}).ready()
    assert (bench.read(BELT + MIN, Type.INT32), bench.read(BELT + MAX, Type.INT32)) == (-250, 350)
    bench.order(START, target=900)
    assert (bench.place, bench.status) == (350, REACHED | LIMITED)


def test_without_limits_their_registers_are_the_ends_of_32_bits() -> None:
    bench = LimitBench({}).ready()
    assert (bench.read(BELT + MIN, Type.INT32), bench.read(BELT + MAX, Type.INT32)) == (-(2**31), 2**31 - 1)
    bench.order(START, target=900)
    assert (bench.place, bench.status) == (900, REACHED)


@pytest.mark.parametrize(
    ("limits", "wrong"),
    [
        ({"knife": {"negative_limit": "I_bNeg"}}, r"modbus\.limits: expected the name of an axis \(belt\), got knife"),
        (
            {"belt": {"negative_limit": "I_bMeg"}},
            r"modbus\.limits of belt: expected the name of an input or output, got I_bMeg",
        ),
        ({"belt": {"min_position": 5, "max_position": 5}}, "min_position: expected less than max_position 5"),
    ],
)
def test_limits_of_what_is_not_there_are_refused(limits: dict[str, Any], wrong: str) -> None:
    with pytest.raises(ConfigError, match=wrong):
        LimitBench(modbus={"limits": limits})
