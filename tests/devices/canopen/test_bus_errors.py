"""The state of the CAN controller, CiA 301 table 26 and 1029h; and a fault that drives a node into bus-off."""

from typing import Any

import pytest
from canopen_bench import CanopenBench

from fieldrig_bus.can.notices import BusState, CanState

PASSIVE, NO_ERROR, RECOVERED = (
    "085#20 81 11 00 00 00 00 00",
    "085#00 00 00 00 00 00 00 00",
    "085#40 81 11 00 00 00 00 00",
)


def change(bench: CanopenBench, state: CanState) -> list[str]:
    notice: Any = BusState(state, 0, 0)
    bench.can.deliver(notice)
    return bench.after(0)


def test_node_asks_for_the_state_of_its_controller(bench: CanopenBench) -> None:
    assert bench.can.interest is not None
    assert "state" in bench.can.interest


def test_node_alone_on_its_bus_has_nothing_to_report(bench: CanopenBench) -> None:
    assert change(bench, CanState.PASSIVE) == []
    assert change(bench, CanState.ACTIVE) == []


def test_error_passive_is_reported_until_it_is_over(bench: CanopenBench) -> None:
    bench.send("080#")
    assert change(bench, CanState.WARNING) == []
    assert change(bench, CanState.PASSIVE) == [PASSIVE]
    assert bench.send("000#82 05") == ["705#00", PASSIVE]
    assert change(bench, CanState.WARNING) == []
    assert change(bench, CanState.ACTIVE) == [NO_ERROR]


def test_a_controller_around_its_limit_fills_no_bus_with_messages(bench: CanopenBench) -> None:
    """A good frame sets a receive counter above 127 to 119 to 127 (ISO 11898-1), and the next bad one puts it back."""
    bench.send("080#")
    around = [
        message
        for _ in range(100)
        for state in (CanState.PASSIVE, CanState.WARNING)
        for message in change(bench, state)
    ]
    assert around == [PASSIVE]
    assert change(bench, CanState.ACTIVE) == [NO_ERROR]


@pytest.mark.parametrize(("behaviour", "state"), [("00", "pre_operational"), ("01", "operational"), ("02", "stopped")])
def test_error_behaviour_says_what_bus_off_does(bench: CanopenBench, behaviour: str, state: str) -> None:
    bench.write(f"2f 29 10 01 {behaviour} 00 00 00")
    bench.send("000#01 05")
    change(bench, CanState.BUS_OFF)
    assert bench.point("nmt.state") == state


def test_recovery_is_reported(bench: CanopenBench) -> None:
    bench.send("080#")
    change(bench, CanState.PASSIVE)
    assert change(bench, CanState.BUS_OFF) == []
    assert change(bench, CanState.ACTIVE) == [NO_ERROR, RECOVERED, NO_ERROR]


def test_outputs_take_their_error_values_until_the_node_is_started_again() -> None:
    bench = CanopenBench(signals={"6200:01.0": "pump"})
    bench.write("2f 29 10 01 01 00 00 00", "2f 00 62 01 01 00 00 00")
    bench.wires.take()
    bench.send("000#01 05")
    change(bench, CanState.BUS_OFF)
    assert [signal.value for signal in bench.wires.take()] == [False]
    change(bench, CanState.ACTIVE)
    bench.send("000#80 05", "000#01 05")
    assert [signal.value for signal in bench.wires.take()] == [True]
