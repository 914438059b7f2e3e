"""The order in which processes are let start, and what the rig knows of them."""

import asyncio
from collections.abc import Callable, Coroutine
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from fieldrig.config.rig_file import from_dict
from fieldrig.control.events import Event
from fieldrig.control.messages import Control
from fieldrig.errors import ControlError
from fieldrig.real.placement import placement
from fieldrig.real.roster import ProcessState, Roster

HERE = Path(__file__).parents[1]


class Line:
    """Takes the place of the control messages: the test plays the processes."""

    def __init__(self) -> None:
        self.answer: Callable[[str, Any], Coroutine[Any, Any, Any]]
        self.on_life: Callable[[str, bool], None]
        self.states: dict[str, str] = {}
        self.session = SimpleNamespace(info=SimpleNamespace(links=list))
        """A session of Zenoh without connections."""
        self.heard: dict[str, Callable[[str, Any], None]] = {}
        """The handlers, by the first part of their path."""

    def serve(self, _path: str, answer: Any) -> None:
        self.answer = answer

    def listen_to(self, path: str, handler: Any) -> None:
        self.heard[path.removesuffix("/*")] = handler

    def on_ready(self, name: str, message: Any) -> None:
        self.heard["ready"](name, message)

    def watch_life(self, _path: str, handler: Any) -> None:
        self.on_life = handler

    def publish(self, path: str, message: Any) -> None:
        pass

    def limits(self) -> dict[str, float]:
        return {}

    async def ask(self, path: str, _message: Any, _timeout_s: float) -> Any:
        name = path.split("/")[1]
        if name not in self.states:
            raise ControlError(f"there is no answer to {path}")
        return {"state": self.states[name], "pid": 1}


class Bench:
    """w runs the wires; two starts after one."""

    def __init__(self) -> None:
        wires = {"kind": "rig_kinds:Adder", "links": {"wires": "w"}}
        config = from_dict(
            {
                "time": "real",
                "name": "lab",
                "buses": {"w": {"kind": "wires.hub"}},
                "devices": {"one": wires, "two": {**wires, "after": "one"}},
            },
            HERE,
        )
        self.line, self.events = Line(), list[Event]()
        self.roster = Roster(config, placement(config), cast(Control, self.line), self.events.append)
        self.roster.serve()
        self.joins: dict[str, asyncio.Task[Any]] = {}

    async def make_all_ready(self) -> None:
        """Let every process join and become ready."""
        for name in ("w", "one", "two"):
            await self.join(name)
            self.line.on_ready(name, {"pid": 1})

    async def join(self, name: str, pid: int = 1) -> None:
        self.joins[name] = asyncio.create_task(self.line.answer("join", {"process": name, "pid": pid}))
        await self.settle()

    async def settle(self) -> None:
        for _ in range(5):
            await asyncio.sleep(0)

    @property
    def released(self) -> set[str]:
        return {name for name, join in self.joins.items() if join.done()}

    def told(self) -> list[str]:
        return [f"{event.process} {event.what}".strip() for event in self.events]

    async def close(self) -> None:
        for join in self.joins.values():
            join.cancel()
        await asyncio.gather(*self.joins.values(), return_exceptions=True)


def on_bench(case: Callable[[Bench], Coroutine[Any, Any, None]]) -> Callable[[], None]:
    """Run a coroutine function as a test, with a bench in an event loop of its own."""

    async def on_new_bench() -> None:
        bench = Bench()
        try:
            await case(bench)
        finally:
            await bench.close()

    def run() -> None:
        asyncio.run(on_new_bench())

    return run


@on_bench
async def test_devices_wait_until_their_hub_is_open_and_those_before_them_are_ready(bench: Bench) -> None:
    await bench.join("two")
    await bench.join("one")
    assert bench.released == set()
    await bench.join("w")
    assert bench.released == {"w", "one"}
    bench.line.on_ready("w", {"pid": 1})
    assert bench.released == {"w", "one"}
    bench.line.on_ready("one", {"pid": 1})
    await bench.settle()
    assert bench.released == {"w", "one", "two"}
    bench.line.on_ready("two", {"pid": 1})
    assert bench.told() == ["w ready", "one ready", "two ready", "ready"]


@on_bench
async def test_a_process_that_comes_back_waits_for_nobody_who_is_there(bench: Bench) -> None:
    await bench.make_all_ready()
    bench.roster.set_state(bench.roster.members["two"], ProcessState.DEAD)
    assert bench.roster.status()["state"] == "degraded"
    await bench.join("two", pid=2)
    assert bench.joins["two"].done()
    bench.line.on_ready("two", {"pid": 1})  # from before it died
    assert bench.roster.members["two"].state is ProcessState.RELEASED
    bench.line.on_ready("two", {"pid": 2})
    assert bench.roster.status()["state"] == "ready"
    assert bench.told().count("ready") == 1


@on_bench
async def test_one_that_died_for_good_is_not_waited_for(bench: Bench) -> None:
    await bench.make_all_ready()
    bench.roster.set_state(bench.roster.members["one"], ProcessState.GONE)
    assert bench.roster.status()["state"] == "ready"
    await bench.join("two")
    assert bench.joins["two"].done()


@on_bench
async def test_a_hub_that_is_being_started_again_is_waited_for(bench: Bench) -> None:
    await bench.make_all_ready()
    bench.roster.set_state(bench.roster.members["w"], ProcessState.DEAD)
    await bench.join("one")
    assert not bench.joins["one"].done()
    await bench.join("w")
    assert bench.joins["one"].done()


@on_bench
async def test_a_new_service_finds_processes_that_joined_the_last_one(bench: Bench) -> None:
    bench.roster.watch()
    bench.line.states = {"w": "ready", "one": "ready", "two": "starting"}
    for name in bench.line.states:
        bench.line.on_life(name, True)
    await bench.settle()
    assert [member.state for member in bench.roster.members.values()] == ["ready", "ready", "starting"]
    del bench.line.states["one"]
    bench.line.on_life("one", False)
    await bench.settle()
    assert bench.roster.members["one"].state is ProcessState.DEAD


@on_bench
async def test_a_process_whose_former_connection_ends_late_is_not_gone(bench: Bench) -> None:
    await bench.make_all_ready()
    bench.roster.watch()
    bench.line.states = {"one": "ready"}
    bench.events.clear()
    for name in ("one", "two"):
        bench.line.on_life(name, False)
    await bench.settle()
    assert [(event.what, event.process) for event in bench.events] == [
        ("gone", "one"),
        ("gone", "two"),
        ("ready", "one"),
    ]
    assert bench.roster.members["two"].state is ProcessState.DEAD


@on_bench
async def test_strangers_and_unknown_verbs_are_refused(bench: Bench) -> None:
    with pytest.raises(ControlError, match="this rig cannot join process three, pid 1"):
        await bench.line.answer("join", {"process": "three", "pid": 1})
    with pytest.raises(ControlError, match="cannot step"):
        await bench.line.answer("step", None)
    garbage: list[Any] = [None, [], {"process": "one"}, {"process": 1, "pid": 1}]
    for message in garbage:
        with pytest.raises(ControlError, match="this rig cannot join"):
            await bench.line.answer("join", message)


@on_bench
async def test_a_warning_of_a_process_is_an_event_and_nothing_else_is(bench: Bench) -> None:
    bench.line.heard["warning"]("one", {"text": "one cannot store anything: No space left on device"})
    assert [(event.what, event.process, event.text) for event in bench.events] == [
        ("warning", "one", "one cannot store anything: No space left on device")
    ]
    garbage: list[tuple[str, Any]] = [("three", {"text": "x"}), ("one", None), ("one", {"text": 1}), ("one", ["text"])]
    for name, message in garbage:
        bench.line.heard["warning"](name, message)
    assert len(bench.events) == 1


@on_bench
async def test_a_late_host_is_told_once_for_all_processes_and_its_end_once(bench: Bench) -> None:
    await bench.make_all_ready()
    bench.events.clear()
    late = bench.line.heard["late"]
    late("one", {"words": "timers are up to 80 ms late; load 30 on 2 cores"})
    late("two", {"words": "ring keeps 41 % of its cycles; load 30 on 2 cores"})
    assert bench.roster.status()["late"] == {
        "one": "timers are up to 80 ms late; load 30 on 2 cores",
        "two": "ring keeps 41 % of its cycles; load 30 on 2 cores",
    }
    late("one", {"words": ""})
    bench.roster.set_state(bench.roster.members["two"], ProcessState.DEAD)
    garbage: list[tuple[str, Any]] = [("three", {"words": "x"}), ("one", None), ("one", {"words": 1}), ("one", [])]
    for name, message in garbage:
        late(name, message)
    assert [(event.what, event.process, event.text) for event in bench.events] == [
        ("warning", "one", "the host is late: timers are up to 80 ms late; load 30 on 2 cores"),
        ("warning", "two", "the host is on time again"),
    ]
    assert bench.roster.status()["late"] == {}
