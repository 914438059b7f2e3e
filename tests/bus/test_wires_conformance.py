"""Every link that carries signals keeps the same promises, regardless of its kind."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Protocol

import pytest
from hub_bench import Where, hub_bench
from zenoh_bench import ZenohAt, ZenohBench, zenoh_bench

from fieldrig.config.rig_file import from_dict
from fieldrig.link import Link
from fieldrig.testing import free_port
from fieldrig.virtual.rig import Rig
from fieldrig_bus.wires import Signal, WiresHub, WiresHubSettings
from fieldrig_bus.wires_zenoh import WiresZenoh, WiresZenohSettings


class Bench(Protocol):
    def join(self, member: str) -> Link[Signal]: ...

    def pump(self, until: Callable[[], bool]) -> None: ...


class VirtualBench:
    def __init__(self, rig: Rig) -> None:
        self._rig = rig

    def join(self, member: str) -> Link[Signal]:
        return self._rig.attach(member).link("w")

    def pump(self, until: Callable[[], bool]) -> None:
        while not until():
            assert self._rig.step(), "nothing is under way any more"


@contextmanager
def virtual() -> Iterator[Bench]:
    with Rig(from_dict({"time": "virtual", "buses": {"w": {"kind": "wires.virtual"}}}, Path())) as rig:
        yield VirtualBench(rig)


@contextmanager
def hub(where: Where) -> Iterator[Bench]:
    with hub_bench(lambda attach: WiresHub("w", WiresHubSettings(attach=attach)), where, free_port()) as bench:
        yield bench


BACKENDS: dict[str, Callable[[], AbstractContextManager[Bench]]] = {
    "virtual": virtual,
    "hub, here": lambda: hub("here"),
    "hub, unix": lambda: hub("unix"),
    "hub, tcp": lambda: hub("tcp"),
    "zenoh, one session": lambda: zenoh_bench(True),
    "zenoh, a session each": lambda: zenoh_bench(False),
}


@pytest.fixture(params=BACKENDS, ids=str)
def bench(request: pytest.FixtureRequest) -> Iterator[Bench]:
    with BACKENDS[request.param]() as bench:
        yield bench


pytestmark = pytest.mark.system


def listen(link: Link[Signal], names: list[str] | None = None) -> list[Signal]:
    heard: list[Signal] = []
    link.on_receive(heard.append, names)
    return heard


def meet(bench: Bench, driver: Link[Signal], listeners: list[list[Signal]]) -> None:
    """Wait until a signal "mark" of the driver is received: after that, nothing is missed."""
    driver.send(Signal("mark", True))
    bench.pump(lambda: all(Signal("mark", True) in heard for heard in listeners))


def test_a_signal_reaches_the_listeners_of_its_name_in_order(bench: Bench) -> None:
    pump, tank, panel = (bench.join(name) for name in ("pump", "tank", "panel"))
    at_tank, at_panel = listen(tank, ["mark", "run"]), listen(panel)
    meet(bench, pump, [at_tank, at_panel])
    for speed in (10, 20.5):
        pump.send(Signal("speed", speed, "%"))
        pump.send(Signal("run", True))
    pump.send(Signal("run", False))
    bench.pump(lambda: at_tank[-1:] == [Signal("run", False)] == at_panel[-1:])
    assert at_tank[1:] == [Signal("run", True), Signal("run", True), Signal("run", False)]
    assert at_panel[1:] == [
        Signal("speed", 10, "%"),
        Signal("run", True),
        Signal("speed", 20.5, "%"),
        Signal("run", True),
        Signal("run", False),
    ]


def test_a_late_listener_gets_the_present_value_once(bench: Bench) -> None:
    tank, witness, panel = (bench.join(name) for name in ("tank", "witness", "panel"))
    at_witness = listen(witness)
    meet(bench, tank, [at_witness])
    tank.send(Signal("level", 1.0, "m"))
    tank.send(Signal("level", 2.0, "m"))
    bench.pump(lambda: at_witness[-1] == Signal("level", 2.0, "m"))
    at_panel = listen(panel, ["level", "mark"])
    meet(bench, tank, [at_panel])
    bench.pump(lambda: Signal("level", 2.0, "m") in at_panel)
    assert [signal for signal in at_panel if signal.name == "level"] == [Signal("level", 2.0, "m")]


def test_a_driver_does_not_hear_itself(bench: Bench) -> None:
    tank, panel = bench.join("tank"), bench.join("panel")
    tank.send(Signal("level", 1.0, "m"))
    at_tank, at_panel = listen(tank), listen(panel)
    meet(bench, tank, [at_panel])
    panel.send(Signal("lamp", True))
    bench.pump(lambda: bool(at_tank))
    assert at_tank == [Signal("lamp", True)]


def test_another_interest_takes_the_place_of_the_first(bench: Bench) -> None:
    tank, panel = bench.join("tank"), bench.join("panel")
    first = listen(panel, ["mark", "level"])
    meet(bench, tank, [first])
    second = listen(panel, ["mark", "outlet"])
    meet(bench, tank, [second])
    tank.send(Signal("level", 3.0, "m"))
    tank.send(Signal("outlet", 50, "%"))
    bench.pump(lambda: Signal("outlet", 50, "%") in second)
    assert Signal("level", 3.0, "m") not in first + second


@pytest.mark.parametrize("name", ["tank.level", "a/b", "50 % open?", "*", "äöü#$", ""])
def test_any_name_is_a_name(bench: Bench, name: str) -> None:
    tank, panel = bench.join("tank"), bench.join("panel")
    at_panel = listen(panel, ["mark", name])
    meet(bench, tank, [at_panel])
    tank.send(Signal("other", 0))
    tank.send(Signal(name, -1))
    bench.pump(lambda: Signal(name, -1) in at_panel)
    assert {signal.name for signal in at_panel} == {"mark", name}


def test_bytes_that_are_no_signal_are_dropped() -> None:
    bench = ZenohBench(is_one=False)
    try:
        tank, panel = bench.join("tank"), bench.join("panel")
        at_panel = listen(panel)
        meet(bench, tank, [at_panel])
        bench.sessions[1].put("fieldrig/lab/wires/w/level", b"\xff[1")
        tank.send(Signal("level", 1))
        bench.pump(lambda: Signal("level", 1) in at_panel)
        assert set(at_panel) == {Signal("mark", True), Signal("level", 1)}
    finally:
        bench.close()


def test_the_trace_has_each_signal_once() -> None:
    bench = ZenohBench(is_one=True)
    try:
        at = ZenohAt("tank", bench.clock, bench.sessions[0])
        bus = WiresZenoh("w", WiresZenohSettings())
        tank = bench.loop.run_until_complete(bus.open(at))
        tank.send(Signal("level", 1))
        assert at.traced == [("tank", Signal("level", 1))]
        bench.loop.run_until_complete(bus.close("tank"))
    finally:
        bench.close()
