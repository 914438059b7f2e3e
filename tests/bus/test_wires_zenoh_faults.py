"""Each fault of wires on `wires.zenoh`: at the end of the driver, for those that listen already and for later ones."""

from collections.abc import Iterator
from typing import Any

import pytest
from zenoh_bench import ZenohAt, ZenohBench, zenoh_bench

from fieldrig.faults.note import FaultNote
from fieldrig_bus.wires import Signal
from fieldrig_bus.wires_zenoh import WiresEnd, WiresZenoh, WiresZenohSettings

pytestmark = pytest.mark.system

LEVEL, RUN = Signal("level", 2.0, "m"), Signal("run", True)


@pytest.fixture
def bench() -> Iterator[ZenohBench]:
    with zenoh_bench(is_one=True) as bench:
        yield bench


def listen(link: WiresEnd, *names: str) -> list[Signal]:
    heard: list[Signal] = []
    link.on_receive(heard.append, list(names))
    return heard


@pytest.mark.parametrize(
    ("fault", "driven", "wrong"),
    [
        ({"what": "stuck", "wire": "level", "value": 7.5}, LEVEL, Signal("level", 7.5, "m")),
        ({"what": "stuck", "wire": "run", "value": False}, RUN, Signal("run", False)),
        ({"what": "offset", "wire": "level", "factor": 2, "offset": 0.5}, LEVEL, Signal("level", 4.5, "m")),
        ({"what": "drop_out", "wire": "run"}, RUN, Signal("run", False)),
        ({"what": "swapped", "wire": "level", "other": "height"}, LEVEL, Signal("height", 2.0, "m")),
    ],
    ids=str,
)
def test_listeners_get_the_wrong_value_while_the_fault_is_on(
    bench: ZenohBench, fault: dict[str, Any], driven: Signal, wrong: Signal
) -> None:
    names = {driven.name, wrong.name}
    tank, panel, late, last = (bench.join(name) for name in ("tank", "panel", "late", "last"))
    at_panel = listen(panel, *names)
    tank.send(driven)
    bench.pump(lambda: at_panel == [driven])
    number = tank.injected.add_fault(fault)
    bench.pump(lambda: at_panel == [driven, wrong])
    at_late = listen(late, *names)
    bench.pump(lambda: at_late == [wrong])
    tank.injected.clear_fault(number)
    bench.pump(lambda: at_panel == [driven, wrong, driven])
    at_last = listen(last, *names)
    bench.pump(lambda: at_last == [driven])


def test_a_contact_bounces_and_comes_to_rest(bench: ZenohBench) -> None:
    tank, panel = bench.join("tank"), bench.join("panel")
    at_panel = listen(panel, "run")
    tank.injected.add_fault({"what": "bounce", "wire": "run", "pulses": 2, "length_ms": 4})
    tank.send(Signal("run", False))
    tank.send(Signal("run", True))
    bench.pump(lambda: len(at_panel) == 6)
    assert [signal.value for signal in at_panel] == [False, True, False, True, False, True]


def test_noise_goes_on_by_itself(bench: ZenohBench) -> None:
    tank, panel = bench.join("tank"), bench.join("panel")
    at_panel = listen(panel, "level")
    tank.send(LEVEL)
    tank.injected.add_fault({"what": "noise", "wire": "level", "amplitude": 0.5, "period_ms": 1})
    bench.pump(lambda: len({signal.value for signal in at_panel}) > 5)
    assert all(1.5 <= signal.value <= 2.5 for signal in at_panel)


def test_a_fault_of_the_rig_file_is_applied_counted_and_in_the_trace() -> None:
    settings = WiresZenohSettings.model_validate({"faults": [{"what": "stuck", "wire": "level", "value": 0}]})
    with zenoh_bench(is_one=True, settings=settings) as bench:
        at = ZenohAt("tank", bench.clock, bench.sessions[0])
        bus = WiresZenoh("w", settings)
        tank = bench.loop.run_until_complete(bus.open(at))
        tank.send(LEVEL)
        assert at.traced == [("tank", FaultNote(1, "stuck at 0")), ("tank", Signal("level", 0, "m"))]
        assert tank.injected.faults()[1]["applied"] == 1
        assert all(bus.decode(bus.encode(message)) == message for _, message in at.traced)
        bench.loop.run_until_complete(bus.close("tank"))


def test_digital_outputs_are_off_without_power(bench: ZenohBench) -> None:
    tank, panel = bench.join("tank"), bench.join("panel")
    at_panel = listen(panel, "run", "level")
    tank.send(RUN)
    tank.send(LEVEL)
    bench.pump(lambda: at_panel == [RUN, LEVEL])
    tank.switch(False)
    bench.pump(lambda: at_panel[2:] == [Signal("run", False)])
    tank.switch(True)
    tank.send(RUN)
    bench.pump(lambda: at_panel[3:] == [RUN])
