"""A rig gives the same bytes if a device that acts alone is run without a look at all the others, and if not."""

from functools import partial
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig import MS, ArgumentError, Bus, Delivery, Rig, S, from_dict
from fieldrig.testing import plain_forms
from fieldrig.virtual.engine import ALONE, Engine
from fieldrig_bus.wires import Signal

HERE = Path(__file__).parents[1]
WIRES = {"wires": "wires"}
RIG: dict[str, Any] = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {
        "one": {"kind": "rig_kinds:Dice", "links": WIRES, "period_ms": 3},
        "two": {"kind": "rig_kinds:Dice", "links": WIRES, "period_ms": 7},
        "adder": {"kind": "rig_kinds:Adder", "links": WIRES},
        "ticker": {"kind": "rig_kinds:Ticker", "links": WIRES},
    },
}
bench_sends = st.lists(st.integers(0, 50), max_size=6)
"""Instants at which the bench sends by a timer of its own, in ms."""
strides = st.lists(st.integers(0, 40 * MS), min_size=1, max_size=6)
heard_wires = st.sampled_from([None, [], ["adder.sum"], ["ticker.ticks"], ["two.thrown"]])


class Seen:
    """Everything that can be seen of a rig while it runs."""

    def __init__(self) -> None:
        self.lines: list[Any] = []

    def on_delivery(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        receivers = tuple(delivery.receivers)
        self.lines.append((delivery.time_ns, delivery.sender, bus.encode(delivery.message), receivers))


def seen(sends: list[int], strides_ns: list[int], interest: list[str] | None, stops_at: int) -> list[Any]:
    trace = Seen()
    with Rig(from_dict(RIG, HERE), trace.on_delivery) as rig:
        bench = rig.attach("bench")
        wires = bench.link("wires")
        heard: list[Any] = []
        wires.on_receive(heard.append, interest)
        due = [stops_at]
        for number, ms in enumerate(sends):
            bench.clock.call_at(ms * MS, partial(wires.send, Signal("one.thrown", number)))
        for stride_ns in strides_ns:
            until_ns = rig.now_ns + stride_ns
            while not rig.run_until(until_ns, lambda: len(heard) >= due[0]):
                due[0] = len(heard) + stops_at
                trace.lines.append((rig.now_ns, bench.clock.now_ns(), len(heard), rig.get("ticker/ticks")))
            trace.lines.append((rig.now_ns, bench.clock.now_ns(), len(heard), rig.get("ticker/ticks")))
    return trace.lines


@settings(max_examples=60, deadline=None)
@given(bench_sends, strides, heard_wires, st.integers(1, 3))
def test_a_member_from_outside_sees_the_same_of_a_rig_that_takes_the_short_way(
    sends: list[int], strides_ns: list[int], interest: list[str] | None, stops_at: int
) -> None:
    with plain_forms(ALONE.name):
        plain = seen(sends, strides_ns, interest, stops_at)
    assert seen(sends, strides_ns, interest, stops_at) == plain


def test_a_rig_stops_at_the_instant_at_which_the_condition_holds() -> None:
    with Rig(from_dict(RIG, HERE)) as rig:
        heard: list[Any] = []
        rig.attach("bench").link("wires").on_receive(heard.append, ["two.thrown"])
        assert rig.run_until(S, lambda: len(heard) == 2) is False
        assert (rig.now_ns, len(heard)) == (7 * MS, 2)
        assert rig.run_until(20 * MS, lambda: False) is True
        assert rig.now_ns == 20 * MS


def test_a_rig_with_a_member_from_outside_looks_at_all_members_only_when_it_has_to(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def instants() -> int:
        count = 0
        run = Engine.run_instant

        def counted(engine: Engine, now_ns: int) -> None:
            nonlocal count
            count += 1
            run(engine, now_ns)

        with monkeypatch.context() as patch, Rig(from_dict(RIG, HERE)) as rig:
            patch.setattr(Engine, "run_instant", counted)
            rig.attach("bench").link("wires").on_receive(lambda _: None)
            rig.run_until(100 * MS)
        return count

    with plain_forms(ALONE.name):
        plain = instants()
    assert instants() < plain / 10


def test_a_member_from_outside_that_acts_alone_sends_at_its_instants() -> None:
    trace = Seen()
    with Rig(from_dict({**RIG, "devices": {}}, HERE), trace.on_delivery) as rig:
        bench = rig.attach("bench")
        for ms in (1, 2, 5):
            bench.clock.call_at(ms * MS, partial(bench.link("wires").send, Signal("one.thrown", ms)))
        rig.run_until(10 * MS)
    assert [instant_ns for instant_ns, *_ in trace.lines] == [1 * MS, 2 * MS, 5 * MS]


def test_what_to_call_is_a_function() -> None:
    with Rig(from_dict(RIG, HERE)) as rig, pytest.raises(ArgumentError, match="run_until cannot call 5"):
        rig.run_until(S, 5)  # type: ignore[arg-type]


def test_a_member_that_is_detached_hears_nothing_and_its_name_is_free() -> None:
    with Rig(from_dict(RIG, HERE)) as rig:
        heard: list[Any] = []
        bench = rig.attach("bench")
        bench.link("wires").on_receive(heard.append)
        bench.clock.call_at(30 * MS, lambda: heard.append("timer"))
        rig.run_until(8 * MS)
        rig.detach("bench")
        count = len(heard)
        rig.run_until(50 * MS)
        assert len(heard) == count
        rig.attach("bench")
