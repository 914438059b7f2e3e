"""A slave that a master manages: node 1 on a bench, frame by frame, and our own node on a bus."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import pytest
from canopen_bench import IO32, parse, show
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.config.rig_file import from_dict
from fieldrig.testing import RecordedLink
from fieldrig.virtual.node import EventNode
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.managed_slave import ManagedSlave, Presence, Write, watch_over
from fieldrig_devices.canopen.service import State

PRE_OPERATIONAL, START = "000#80 01", "000#01 01"
HEARTBEAT, TAKEN = "601#2b 17 10 00 64 00 00 00", "581#60 17 10 00 00 00 00 00"  # 1017h := 100 ms
TIMED_OUT = "601#80 17 10 00 00 00 04 05"
REFUSED = "581#80 17 10 00 02 00 01 06"
BOOT_UP, RUNS, WAITS, STOPPED = "701#00", "701#05", "701#7f", "701#04"


class Bench:
    def __init__(self, heartbeat_ms: int = 100, **options: Any) -> None:
        self.clock, self.can = VirtualClock(), RecordedLink[CanFrame]()
        self.said: list[str] = []
        self.node = ManagedSlave(
            self.clock,
            self.can,
            1,
            heartbeat_ms,
            lambda: self.said.append("lost"),
            lambda: self.said.append("back"),
            sdo_timeout_ns=50 * MS,
            **options,
        )

    def receive(self, *frames: str) -> list[str]:
        for frame in frames:
            self.can.deliver(parse(frame))
        return self.take()

    def after(self, ms: int) -> list[str]:
        self.clock.advance_to(self.clock.now_ns() + ms * MS)
        return self.take()

    def take(self) -> list[str]:
        return [show(frame) for frame in self.can.take()]

    def take_calls(self) -> list[str]:
        """Return the calls of `on_lost` and `on_back` since the last time."""
        said, self.said = self.said, []
        return said

    def presence(self) -> Presence:
        return self.node.presence


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def running(bench: Bench) -> Bench:
    bench.node.start()
    bench.receive(TAKEN)
    assert bench.take_calls() == ["back"]
    return bench


def test_slave_is_configured_then_started(bench: Bench) -> None:
    bench.node.start()
    assert bench.take() == [PRE_OPERATIONAL, HEARTBEAT]
    assert bench.presence() is Presence.CONFIGURING
    assert bench.receive(TAKEN) == [START]
    assert bench.node.is_running
    assert bench.take_calls() == ["back"]


def test_configuration_is_written_in_order_heartbeat_last() -> None:
    bench = Bench(configuration=[Write(0x6206, 1, b"\xff"), watch_over(10, 300)])
    bench.node.start()
    assert bench.take() == [PRE_OPERATIONAL, "601#2f 06 62 01 ff 00 00 00"]
    assert bench.receive("581#60 06 62 01 00 00 00 00") == ["601#23 16 10 01 2c 01 0a 00"]
    assert bench.receive("581#60 16 10 01 00 00 00 00") == [HEARTBEAT]
    assert bench.receive(TAKEN) == [START]


def test_what_a_slave_refuses_is_told_and_it_is_started_all_the_same() -> None:
    bench = Bench(configuration=[Write(0x6206, 1, b"\xff")])
    bench.node.start()
    bench.receive("581#80 06 62 01 00 00 02 06")
    assert bench.receive(TAKEN) == [START]
    ((write, abort),) = bench.node.refused.items()
    assert (write.index, abort.code) == (0x6206, Code.NO_OBJECT)


def test_before_our_start_nothing_is_done(bench: Bench) -> None:
    assert bench.receive(BOOT_UP, RUNS) == []
    assert bench.presence() is Presence.OFF


def test_boot_up_while_being_configured_begins_again(bench: Bench) -> None:
    bench.node.start()
    bench.take()
    assert bench.receive(BOOT_UP) == [HEARTBEAT]
    assert bench.receive(TAKEN) == [START]
    assert bench.take_calls() == ["back"]


def test_slave_that_does_not_answer_is_lost_and_asked_again(bench: Bench) -> None:
    bench.node.start()
    bench.take()
    assert bench.after(50) == [TIMED_OUT]
    assert bench.take_calls() == ["lost"]
    assert bench.after(999) == []
    assert bench.after(1) == [PRE_OPERATIONAL, HEARTBEAT]
    assert bench.after(50) == [TIMED_OUT]
    assert bench.take_calls() == []


@pytest.mark.parametrize("first", [BOOT_UP, WAITS, RUNS, STOPPED])
def test_slave_that_comes_later_is_taken_up(bench: Bench, first: str) -> None:
    bench.node.start()
    bench.after(200)
    assert bench.receive(first) == [*([] if first == BOOT_UP else [PRE_OPERATIONAL]), HEARTBEAT]
    assert bench.receive(TAKEN) == [START]
    assert bench.take_calls() == ["lost", "back"]


def test_heartbeat_keeps_a_slave(running: Bench) -> None:
    for _ in range(10):
        assert running.after(199) == []
        assert running.receive(RUNS) == []
    assert running.take_calls() == []


def test_slave_without_a_heartbeat_is_lost(running: Bench) -> None:
    running.receive(RUNS)
    running.after(199)
    assert running.take_calls() == []
    running.after(1)
    assert running.take_calls() == ["lost"]
    assert not running.node.is_running
    assert running.node.state is None


def test_slave_that_never_sends_the_heartbeat_it_was_told_to_send_is_lost(running: Bench) -> None:
    running.after(200)
    assert running.take_calls() == ["lost"]


def test_limit_may_be_given() -> None:
    bench = Bench(limit_ms=500)
    bench.node.start()
    bench.receive(TAKEN)
    bench.after(499)
    assert bench.take_calls() == ["back"]
    bench.after(1)
    assert bench.take_calls() == ["lost"]


def test_slave_that_is_heard_again_is_configured_and_started_again(running: Bench) -> None:
    running.after(200)
    assert running.receive(RUNS) == [PRE_OPERATIONAL, HEARTBEAT]
    assert running.receive(TAKEN) == [START]
    assert running.take_calls() == ["lost", "back"]


def test_slave_that_reboots_was_lost_for_a_moment(running: Bench) -> None:
    running.receive(RUNS)
    assert running.receive(BOOT_UP) == [HEARTBEAT]
    assert running.take_calls() == ["lost"]
    assert running.receive(TAKEN) == [START]
    assert running.take_calls() == ["back"]


@pytest.mark.parametrize("state", [WAITS, STOPPED])
def test_slave_that_has_left_operational_is_started_again(running: Bench, state: str) -> None:
    assert running.receive(state) == [START]
    assert running.receive(RUNS) == []
    assert running.node.state is State.OPERATIONAL
    assert running.take_calls() == []


def test_slave_that_takes_no_heartbeat_time_is_watched_from_its_first_heartbeat_on(bench: Bench) -> None:
    bench.node.start()
    assert bench.receive(REFUSED)[-1] == START
    bench.after(10_000)
    assert bench.take_calls() == ["back"]
    bench.receive(RUNS)
    bench.after(200)
    assert bench.take_calls() == ["lost"]


def test_without_a_heartbeat_time_nothing_is_watched() -> None:
    bench = Bench(0)
    bench.node.start()
    assert bench.take() == [PRE_OPERATIONAL, START]
    bench.receive(RUNS)
    assert bench.after(10_000) == []
    assert bench.take_calls() == ["back"]


def test_stopped_watch_is_silent_until_it_is_started_again(running: Bench) -> None:
    running.node.stop()
    assert running.after(10_000) == []
    assert running.receive(BOOT_UP, WAITS) == []
    running.node.start()
    assert running.take() == [PRE_OPERATIONAL, HEARTBEAT]


def test_its_sdo_client_is_there_for_others(running: Bench) -> None:
    results: list[bytes | Abort] = []
    running.node.sdo.upload(0x6000, 1, results.append)
    assert running.take() == ["601#40 00 60 01 00 00 00 00"]
    running.receive("581#4f 00 60 01 5a 00 00 00")
    assert results == [b"\x5a"]


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from([0x701, 0x581]), st.binary(max_size=8) | st.sampled_from([b"\0", b"\5"]))
        | st.integers(1, 400),
        max_size=12,
    )
)
def test_whatever_comes_lost_and_back_take_turns(events: list[tuple[int, bytes] | int]) -> None:
    bench = Bench()
    bench.node.start()
    for event in events:
        if isinstance(event, int):
            bench.after(event)
        else:
            bench.can.deliver(CanFrame(*event))
    said = bench.take_calls()
    assert all(before != after for before, after in pairwise(said))
    assert bench.node.is_running == (said[-1:] == ["back"])


# With our own node on a bus


class Plant:
    """The I/O module on a bus, with a master."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.said: list[tuple[int, str]] = []
        master: EventNode = rig.attach("master")
        self.clock = master.clock
        self.node = ManagedSlave(
            self.clock, master.link("can0"), 1, 100, lambda: self._on("lost"), lambda: self._on("back")
        )
        self.node.start()

    def _on(self, what: str) -> None:
        self.said.append((self.clock.now_ns() // MS, what))

    def state(self) -> object:
        return self.rig.get("io", "nmt.state")


def config(**node: Any) -> dict[str, Any]:
    links = {"can": "can0"}
    return {
        "time": "virtual",
        "buses": {"can0": {"kind": "can.virtual", "bitrate": 500_000, "acknowledge": "always"}},
        "devices": {"io": {"kind": "canopen.node", "node_id": 1, "eds": str(IO32), "links": links, **node}},
    }


@pytest.fixture
def plant() -> Iterator[Plant]:
    with Rig(from_dict(config())) as rig:
        yield Plant(rig)


def test_our_node_is_started_and_watched(plant: Plant) -> None:
    plant.rig.run_until(1 * S)
    assert plant.state() == "operational"
    assert plant.rig.get("io", "1017:00") == 100
    assert [what for _, what in plant.said] == ["back"]


def test_node_whose_plug_is_pulled_is_lost_and_back(plant: Plant) -> None:
    plant.rig.run_until(1 * S)
    for end in ({"node": "io"}, {"receivers": ["io"]}):
        plant.rig.add_fault("can0", {"what": "drop", "duration_ms": 2000, **end})
    plant.rig.run_until(5 * S)
    assert [what for _, what in plant.said] == ["back", "lost", "back"]
    lost_ms = plant.said[1][0]
    assert 1100 <= lost_ms <= 1200  # 200 ms after the last heartbeat
    assert plant.state() == "operational"


@pytest.mark.parametrize("command", ["81 01", "82 01"])
def test_node_that_another_master_resets_is_configured_and_started_again(plant: Plant, command: str) -> None:
    other = plant.rig.attach("other").link("can0")
    plant.rig.run_until(1 * S)
    other.send(CanFrame(0, bytes.fromhex(command)))
    plant.rig.run_until(2 * S)
    assert [what for _, what in plant.said] == ["back", "lost", "back"]
    assert (plant.state(), plant.rig.get("io", "1017:00")) == ("operational", 100)


@pytest.mark.parametrize("command", ["02 01", "80 01"])
def test_node_that_another_master_stops_is_started_again(plant: Plant, command: str) -> None:
    other = plant.rig.attach("other").link("can0")
    plant.rig.run_until(1050 * MS)  # between two heartbeats
    other.send(CanFrame(0, bytes.fromhex(command)))
    plant.rig.run_until(1051 * MS)
    assert plant.state() != "operational"
    plant.rig.run_until(2 * S)
    assert plant.state() == "operational"
    assert [what for _, what in plant.said] == ["back"]


def test_node_that_ran_before_its_master_is_taken_over() -> None:
    with Rig(from_dict(config())) as rig:
        other = rig.attach("other").link("can0")
        rig.run_until(1 * S)
        other.send(CanFrame(0, b"\x02\x00"))
        rig.run_until(2 * S)
        assert rig.get("io", "nmt.state") == "stopped"
        plant = Plant(rig)
        rig.run_until(3 * S)
        assert plant.state() == "operational"
        assert [what for _, what in plant.said] == ["back"]
