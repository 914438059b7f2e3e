"""Smart-IO nodes on the ring of a PAM: start, changes of inputs, a motor with its plant, breaks, refused items."""

from typing import Any

import pytest
from pamring_bench import SHORT, Pam
from pydantic import ValidationError
from smart_io_bench import COUNTER, DEC, INC, MOTOR, ZERO, SmartIoBench

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import RigError
from fieldrig.virtual.rig import Rig
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.frames import (
    Answer,
    Configuration,
    CounterItem,
    InputChanged,
    InputItem,
    KeyItem,
    KeyMode,
    LedItem,
    Motor,
    MotorItem,
    MotorOrder,
    MotorReport,
    NodeType,
    OutputItem,
    Read,
    Report,
    SetOutput,
)
from fieldrig_devices.smart_io.settings import SmartIoSettings

NODE: dict[str, Any] = {"kind": "smart_io", "modules": {1: {}, 2: {}}, "links": {"ring": "ring", "wires": "wires"}}
RAIL = {"in101": "rail.pulse", "in102": "rail.zero", "out201": "rail.inc", "out202": "rail.dec"}
RAIL_MOTOR = {
    "kind": "plant.dc-motor", "links": {"wires": "wires"}, "increase_wire": "rail.inc", "decrease_wire": "rail.dec",
}  # fmt: skip
ITEMS: list[Configuration] = [
    OutputItem(INC, 201, 1, True), OutputItem(DEC, 202, 1, True), InputItem(ZERO, 102, 1, True, 1, 1),
    CounterItem(COUNTER, 101, True, 1, 1), MotorItem(MOTOR, INC, DEC, ZERO, COUNTER, 500, 2),
    InputItem(10, 103, 2, True, 1, 1), OutputItem(11, 105, 1, True), LedItem(12, 6),
    KeyItem(13, 12, False, KeyMode.TOGGLE, 5),
]  # fmt: skip


class Bench:
    """Two Smart-IO nodes at 41 and 42, the first one with a motor, and a PAM that has started the ring."""

    def __init__(self, *more: Configuration, output: str = "edges") -> None:
        """`output` is the form of the motor's pulses."""
        devices = {
            "tools": {**NODE, "ring_address": 41, "terminals": RAIL},
            "doors": {**NODE, "ring_address": 42},
            "rail": {**RAIL_MOTOR, "output": output},
        }
        buses = {"ring": {"kind": "pamring.virtual"}, "wires": {"kind": "wires.virtual"}}
        self.rig = Rig(from_dict({"time": "virtual", "buses": buses, "devices": devices}))
        member = self.rig.attach("pam")
        self.pam = Pam(member.clock, member.link("ring"), [DeclaredNode(1, NodeType.SMART_IO, 41, 2)], SHORT)
        self.pam.ring.configure(41, [*ITEMS, *more])
        self.pam.ring.configure(42, [InputItem(20, 101, 1, True, 1, 1)])
        self.rig.run_until(0)

    def run(self, time_ms: float) -> list[Report]:
        """Run, and return what the first node has reported."""
        self.pam.reports.clear()
        self.rig.run_until(self.rig.now_ns + round(time_ms * MS))
        return [report for address, report in self.pam.reports if address == 41]

    def started(self) -> "Bench":
        self.pam.start()
        self.run(200)
        assert self.pam.errors == []
        return self


@pytest.mark.long
def test_a_pam_configures_its_nodes_and_gets_all_first_values() -> None:
    bench = Bench()
    assert bench.rig.get("tools", "display") == "F 4"
    bench.rig.run_until(60 * MS)
    assert bench.rig.get("tools", "display") == "F 2", "no cycle arrives"
    bench.started()
    assert bench.pam.codes == [f"07..M{code}" for code in ("003", "004", "00B", "00D", "013", "00E")]
    assert [bench.rig.get("tools", key) for key in ("display", "owner", "error_word")] == [" ", "pam", 0]


@pytest.mark.manual("PAML-093")
def test_changes_of_inputs_and_keys_are_at_the_pam_a_cycle_later() -> None:
    bench = Bench().started()
    bench.rig.set("tools", "in104", True)
    bench.rig.set("tools", "key12", True)
    assert bench.run(10) == [InputChanged(10, 0b10), InputChanged(13, 1)]
    assert bench.run(1_000) == [], "nothing at rest"


def test_orders_switch_outputs_and_leds() -> None:
    bench = Bench().started()
    bench.pam.ring.send(41, SetOutput(11, 1))
    bench.pam.ring.send(41, SetOutput(12, 1))
    bench.run(3)
    assert (bench.rig.get("tools", "out105"), bench.rig.get("tools", "led6")) == (True, True)


@pytest.mark.long
@pytest.mark.manual("PAML-128")
@pytest.mark.parametrize("output", ["edges", "segments"])
def test_a_motor_with_its_plant_finds_zero_and_moves(output: str) -> None:
    bench = Bench(output=output).started()
    bench.pam.ring.send(41, MotorOrder(MOTOR, Motor.ZERO_POSITION, (-1, 1)))
    reports = bench.run(1_000)
    assert [one.is_ready for one in reports if isinstance(one, MotorReport)] == [False, True]
    bench.pam.ring.send(41, MotorOrder(MOTOR, Motor.ABSOLUTE_MOVE, (100,)))
    bench.run(2_000)
    bench.pam.ring.send(41, Read(7, MOTOR))
    assert bench.run(5) == [Answer(7, 100)]
    assert bench.rig.get("rail", "position") == pytest.approx(100, abs=1.5)


def test_a_blocked_motor_is_a_message_of_the_pam() -> None:
    bench = Bench().started()
    bench.rig.add_fault("rail", {"what": "blocked"})
    bench.pam.ring.send(41, MotorOrder(MOTOR, Motor.RUN, (1,)))
    bench.run(600)
    assert bench.pam.errors == [("04..W010", (41, MOTOR, 0x07))]


@pytest.mark.manual("PAMS-105")
def test_an_item_that_can_not_be_is_an_error_of_the_start() -> None:
    bench = Bench(LedItem(99, 200))
    bench.pam.start()
    bench.run(200)
    assert ("04..E01A", (41, 99, 0)) in bench.pam.errors


@pytest.mark.long
@pytest.mark.manual("PAMS-112")
def test_a_break_is_on_the_displays_and_everything_stops() -> None:
    bench = Bench().started()
    bench.pam.ring.send(41, SetOutput(11, 1))
    bench.pam.ring.send(41, MotorOrder(MOTOR, Motor.RUN, (1,)))
    bench.run(100)
    bench.rig.add_fault("ring", {"what": "break", "after": "master"})
    bench.run(200)
    assert [bench.rig.get(node, "display") for node in ("tools", "doors")] == ["F-6", "F 2"]
    assert (bench.rig.get("tools", "out105"), bench.rig.get("rail", "direction")) == (False, 0)


def test_a_ring_needs_an_address_and_two_nodes_have_two() -> None:
    buses = {"ring": {"kind": "pamring.virtual"}, "wires": {"kind": "wires.virtual"}}
    with pytest.raises((RigError, ValueError), match="ring_address"):
        Rig(from_dict({"time": "virtual", "buses": buses, "devices": {"a": NODE}}))
    with pytest.raises(ValidationError):
        SmartIoSettings.model_validate({"ring_address": 256})


def test_an_inquiry_before_run_is_answered() -> None:
    bench = SmartIoBench()
    bench.program.attach(bench.port)
    bench.program.forget()
    bench.order(Read(3, 99))
    assert bench.port.take() == [Answer(3, None)]
