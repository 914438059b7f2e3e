"""Switches along a shaft: edges at the instants at which the position reaches them."""

from math import ceil, pi, sqrt, tau

import pytest
from pydantic import ValidationError

from fieldrig.clock import S, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants.cam_switches import CamSettings, CamSwitches, CamSwitchesSettings


class Bench:
    """One switch that is closed from 3 rad to 3.5 rad of every turn."""

    def __init__(self, every: float | None = tau) -> None:
        self.clock, self.wires = VirtualClock(), RecordedLink[Signal]()
        settings = CamSwitchesSettings(
            position_wire="knife.position", switches={"zero": CamSettings(low=3.0, high=3.5, every=every)}
        )
        self.plant = CamSwitches(self.clock, "cams", settings, self.wires)
        self.plant.start()

    def drive(self, position: float, speed: float = 0.0, acceleration: float = 0.0) -> None:
        self.wires.deliver(Motion("knife.position", position, "rad", self.clock.now_ns(), speed, acceleration))

    def edges(self, until_s: float) -> list[tuple[int, bool]]:
        """Let time pass; return the instants and values of what was sent."""
        found = []
        while self.clock.now_ns() < until_s * S:
            before = len(self.wires.sent)
            self.clock.advance_to(min(self.clock.next_ns() or round(until_s * S), round(until_s * S)))
            found += [(self.clock.now_ns(), bool(signal.value)) for signal in self.wires.sent[before:]]
        return found


def test_switch_is_open_until_the_shaft_is_known() -> None:
    assert Bench().wires.sent == [Signal("cams.zero", False)]


def test_edges_fall_where_the_shaft_reaches_them_in_every_turn() -> None:
    bench = Bench()
    bench.drive(0.0, speed=1.0)
    seconds = [3.0, 3.5, 3.0 + tau, 3.5 + tau]
    found = bench.edges(10.0)
    assert [value for _, value in found] == [True, False, True, False]
    assert [instant for instant, _ in found] == pytest.approx([ceil(second * S) for second in seconds], abs=2)


def test_edges_of_an_accelerated_shaft_follow_its_parabola() -> None:
    bench = Bench(every=None)
    bench.drive(0.0, acceleration=2.0)
    found = bench.edges(5.0)
    assert [instant for instant, _ in found] == pytest.approx([sqrt(at) * S for at in (3.0, 3.5)], abs=2)


def test_shaft_that_turns_back_opens_the_switch_at_the_same_edge() -> None:
    bench = Bench()
    bench.drive(3.2)
    assert bench.wires.sent[-1] == Signal("cams.zero", True)
    bench.drive(3.2, speed=-pi)
    instant, value = bench.edges(1.0)[0]
    assert not value
    assert instant == pytest.approx(0.2 / pi * S, abs=2)


def test_shaft_at_rest_needs_no_timer() -> None:
    bench = Bench()
    bench.drive(1.0)
    assert bench.clock.next_ns() is None


def test_position_that_is_no_number_is_dropped() -> None:
    bench = Bench()
    bench.wires.deliver(Signal("knife.position", float("nan")))
    assert bench.plant.points()["position"].read() == 0.0


def test_cam_without_a_length_is_refused() -> None:
    with pytest.raises(ValidationError, match="expected more than low"):
        CamSettings(low=1.0, high=1.0)
    with pytest.raises(ValidationError, match="less than a period"):
        CamSettings(low=0.0, high=7.0, every=tau)
