"""Virtual time: one scheduler, the same bytes for the same seed, in one process or many."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import ControlError, RigError
from fieldrig.pytest_plugin import RigMaker
from fieldrig.storage.store import MemoryStore
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal

HERE = Path(__file__).parents[1]
WIRES = {"wires": "wires"}


def dice_rig(**changes: Any) -> dict[str, Any]:
    return {
        "time": "virtual",
        "seed": 7,
        "buses": {"wires": {"kind": "wires.virtual"}},
        "devices": {
            "one": {"kind": "rig_kinds:Dice", "links": WIRES},
            "two": {"kind": "rig_kinds:Dice", "links": WIRES, "period_ms": 7},
            "adder": {"kind": "rig_kinds:Adder", "links": WIRES},
        },
        **changes,
    }


class Trace:
    def __init__(self) -> None:
        self.lines: list[tuple[int, str, str, bytes]] = []

    def __call__(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        self.lines.append((delivery.time_ns, bus.name, delivery.sender, bus.encode(delivery.message)))


def trace_of(until_ns: int, **changes: Any) -> list[tuple[int, str, str, bytes]]:
    trace = Trace()
    with Rig(from_dict(dice_rig(**changes), HERE), trace) as rig:
        rig.run_until(until_ns)
    return trace.lines


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    first = trace_of(1 * S)
    assert len(first) > 400
    assert first == trace_of(1 * S)
    assert first != trace_of(1 * S, seed=8)


@pytest.mark.system
def test_one_process_per_device_gives_the_same_bytes() -> None:
    assert trace_of(100 * MS, processes="each") == trace_of(100 * MS)


def test_reactions_happen_at_the_instant_in_the_order_of_the_configuration() -> None:
    assert [(when_ns, sender) for when_ns, _, sender, _ in trace_of(10 * MS)] == [
        (0, "one"), (0, "two"), (0, "adder"), (0, "adder"),
        (7 * MS, "two"), (7 * MS, "adder"),
        (10 * MS, "one"), (10 * MS, "adder"),
    ]  # fmt: skip


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(1, 40 * MS), min_size=1, max_size=8))
def test_it_does_not_matter_in_which_strides_time_is_moved(strides: list[int]) -> None:
    trace = Trace()
    with Rig(from_dict(dice_rig(), HERE), trace) as rig:
        for stride_ns in strides:
            rig.run_until(rig.now_ns + stride_ns)
    assert trace.lines == trace_of(sum(strides))


def test_single_steps_give_the_same_bytes_as_a_run() -> None:
    trace = Trace()
    with Rig(from_dict(dice_rig(), HERE), trace) as rig:
        while (next_ns := rig.next_ns()) is not None and next_ns <= S:
            rig.step()
    assert trace.lines == trace_of(S)


def test_a_rig_goes_from_instant_to_instant_in_single_steps() -> None:
    with Rig(from_dict(dice_rig(), HERE)) as rig:
        instants = []
        for _ in range(5):
            assert rig.step()
            instants.append(rig.now_ns)
        assert instants == [0, 7 * MS, 10 * MS, 14 * MS, 20 * MS]


def test_a_rig_of_nothing_stands_still() -> None:
    with Rig(from_dict({"time": "virtual", "buses": {}, "devices": {}}, HERE)) as rig:
        assert rig.next_ns() is None
        assert not rig.step()
        rig.run_until(5)
        assert rig.now_ns == 5


def test_a_member_from_outside_hears_and_speaks(fieldrig_rig: RigMaker) -> None:
    rig = Rig(from_dict(dice_rig(), HERE))
    bench = rig.attach("bench")
    heard: list[tuple[int, Signal]] = []
    wires = bench.link("wires")
    wires.on_receive(lambda signal: heard.append((bench.clock.now_ns(), signal)), ["adder.sum"])
    rig.run_until(0)
    sum_at_start = int(heard[-1][1].value)
    rig.run_until(5 * MS)
    wires.send(Signal("one.thrown", 100))
    rig.run_until(5 * MS)
    assert heard[-1] == (5 * MS, Signal("adder.sum", sum_at_start + 100))
    with pytest.raises(RigError, match="already has a member 'bench'"):
        rig.attach("bench")
    rig.close()


@pytest.mark.parametrize("processes", ["one", pytest.param("each", marks=pytest.mark.system)])
def test_points_are_read_and_written(processes: str) -> None:
    with Rig(from_dict(dice_rig(processes=processes), HERE)) as rig:
        rig.run_until(25 * MS)
        assert rig.keys("one") == {"throws": "1"}
        assert rig.get("one", "throws") == 3
        rig.set("one", "throws", 40)
        rig.run_until(30 * MS)
        assert rig.get("one", "throws") == 41
        with pytest.raises(ControlError, match="throws cannot be -1: throws are counted from 0"):
            rig.set("one", "throws", -1)
        with pytest.raises(ControlError, match="one has no value 'thorws'"):
            rig.get("one", "thorws")
        with pytest.raises(ControlError, match="no device 'three'"):
            rig.get("three", "throws")


def test_what_a_point_sends_when_it_is_written_arrives() -> None:
    trace = Trace()
    with Rig(from_dict(dice_rig(), HERE), trace) as rig:
        rig.run_until(25 * MS)
        rig.set("one", "throws", 40)
        rig.run_until(25 * MS)
    assert trace.lines[-1] == (25 * MS, "wires", "one", b'["one.throws",40,""]')


def test_memory_is_kept_over_a_power_cycle() -> None:
    stores = {"one": MemoryStore()}
    for expected in (3, 6):
        with Rig(from_dict(dice_rig(), HERE), stores=stores) as rig:
            rig.run_until(25 * MS)
            assert rig.get("one", "throws") == expected


@pytest.mark.long
def test_devices_that_answer_each_other_for_ever_are_named() -> None:
    squabblers = {name: {"kind": "rig_kinds:Squabbler", "links": WIRES} for name in ("ping", "pong")}
    with Rig(from_dict(dice_rig(devices=squabblers), HERE)) as rig, pytest.raises(RigError, match="ping, pong"):
        rig.run_until(1)


def test_a_bus_takes_faults_at_run_time() -> None:
    buses = {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}}
    with Rig(from_dict({"time": "virtual", "seed": 7, "buses": buses})) as rig:
        number = rig.add_fault("can0", {"what": "drop"})
        assert rig.faults("can0")[number]["what"] == "drop"
        rig.clear_fault("can0", number)
        assert rig.faults("can0") == {}
        with pytest.raises(ControlError, match="can0: there is no fault 1"):
            rig.clear_fault("can0", number)
        with pytest.raises(ControlError, match="no bus or device 'can1'"):
            rig.faults("can1")


@pytest.mark.system
@pytest.mark.parametrize("processes", ["one", "each"])
def test_a_device_takes_faults_at_run_time_wherever_it_is(processes: str) -> None:
    trace = Trace()
    with Rig(from_dict(dice_rig(processes=processes), HERE), trace) as rig:
        number = rig.add_fault("one", {"what": "loaded", "duration_ms": "45"})
        rig.run_until(60 * MS)
        assert rig.faults("one")[number] == {"what": "loaded", "duration_ms": 45, "state": "over", "applied": 1}
        rig.clear_fault("one", number)
        assert rig.faults("one") == {}
        with pytest.raises(ControlError, match="one: there is no fault 'loded'"):
            rig.add_fault("one", {"what": "loded"})
        with pytest.raises(ControlError, match=r"adder: there is no fault 'loaded'\n *there are: power_off"):
            rig.add_fault("adder", {"what": "loaded"})
        with pytest.raises(ControlError, match="adder: this device takes no faults"):
            rig.clear_fault("adder", 1)
    sent = [data for when_ns, _, sender, data in trace.lines if sender == "one" and 0 < when_ns <= 60 * MS]
    thrown = [data for data in sent if data.startswith(b'["one.thrown"')]  # and the note that the fault is over
    assert thrown[:4] == [b'["one.thrown",6,""]'] * 4
    assert (len(thrown), len(sent)) == (6, 7)


def affected_frames(seed: int) -> list[tuple[int, str, bytes]]:
    """Return the frames on a CAN bus whose faults depend on chance."""
    can0 = {"kind": "can.virtual", "faults": [{"what": "corrupt", "probability": 0.3}]}
    lines: list[tuple[int, str, bytes]] = []

    def keep(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        lines.append((delivery.time_ns, delivery.sender, bus.encode(delivery.message)))

    with Rig(from_dict({"time": "virtual", "seed": seed, "buses": {"can0": can0}}), on_delivery=keep) as rig:
        sender = rig.attach("sender").link("can0")
        rig.attach("receiver").link("can0").on_receive(lambda _frame: None)
        for number in range(20):
            sender.send(CanFrame(number))
        rig.run_until(S)
    return lines


def test_the_chance_of_a_fault_is_that_of_the_seed() -> None:
    assert affected_frames(1) == affected_frames(1) != affected_frames(2)


@pytest.mark.parametrize(
    ("wire", "note"),
    [
        ("hammer", "in device vase, with a message of bus wires, at 5000000 ns"),
        ("fuse", "in device vase, in a timer or call of its own, at 8000000 ns"),
    ],
)
def test_an_exception_inside_a_device_names_the_device_the_bus_and_the_time(wire: str, note: str) -> None:
    vase = {"vase": {"kind": "rig_kinds:Brittle", "links": WIRES}}
    with Rig(from_dict(dice_rig(devices=vase), HERE)) as rig:
        bench = rig.attach("bench")
        rig.run_until(5 * MS)
        bench.link("wires").send(Signal(wire, True))
        with pytest.raises(RuntimeError, match="it broke") as caught:
            rig.run_until(10 * MS)
    assert caught.value.__notes__ == [note]


def test_an_attached_member_has_no_link_to_a_bus_that_is_not_there() -> None:
    with (
        Rig(from_dict(dice_rig(), HERE)) as rig,
        pytest.raises(RigError, match=r"the rig has no bus 'wirse'\n  did you mean wires\?"),
    ):
        rig.attach("bench").link("wirse")


@pytest.mark.parametrize("until_ns", [1.5, 5e6])
def test_time_is_whole_nanoseconds(until_ns: Any) -> None:
    with Rig(from_dict(dice_rig(), HERE)) as rig:
        with pytest.raises(TypeError, match=f"time is a whole number of nanoseconds, not {until_ns!r}"):
            rig.run_until(until_ns)
        bench = rig.attach("bench")
        with pytest.raises(TypeError, match="time is a whole number of nanoseconds"):
            bench.clock.call_at(until_ns, lambda: None)
        assert rig.now_ns == 0
