"""How long a process that starts is waited for.  The processes are played by the test, in time that it moves."""

import asyncio
import os
import signal
from collections.abc import Awaitable, Callable
from contextlib import suppress
from errno import EMFILE
from pathlib import Path
from typing import Any, cast

import pytest
from jumping_loop import run_jumping

from fieldrig.config.rig_file import from_dict
from fieldrig.control.events import Event
from fieldrig.control.messages import Control, NoAnswerError
from fieldrig.real.children import Children
from fieldrig.real.patience import FIRST_PAUSE_S, LONGEST_LIMIT_S, LONGEST_PAUSE_S, SETTLED_S, Patience
from fieldrig.real.placement import placement
from fieldrig.real.supervisor import GRACE_S, Supervisor
from fieldrig.system.exits import Exit

HERE = Path(__file__).parents[1]
LIMIT_S = 10.0
CRASHED = int(Exit.CRASHED)

Life = Callable[["PlayedProcess"], Awaitable[int]]


class PlayedProcess:
    """A child of the supervisor.  Its lives are played one after the other; each returns its exit code."""

    def __init__(self, bench: "Bench", name: str, lives: list[Life]) -> None:
        self.bench, self.name, self.lives = bench, name, lives
        self.pid: int | None = None
        self.refusals = 0
        """Starts after the first that the system refuses."""
        self.asked_s: list[float] = []
        self.started_s: list[float] = []
        self.killed_s: list[float] = []
        self.log: list[str] = []
        self.on_step: Callable[[str], None] = lambda _step: None
        self.unseen: list[str] = []
        self._life: asyncio.Task[int] | None = None

    async def spawn(self) -> None:
        self.asked_s.append(asyncio.get_running_loop().time())
        if self.refusals and self.started_s:
            self.refusals -= 1
            raise OSError(EMFILE, os.strerror(EMFILE))
        assert self.lives, [(event.process, event.what, event.text) for event in self.bench.events]
        self.pid = 1000 + len(self.started_s)
        self.started_s.append(asyncio.get_running_loop().time())
        self._life = asyncio.ensure_future(self._live(self.lives.pop(0)))

    async def _live(self, life: Life) -> int:
        try:
            return await life(self)
        finally:
            self.pid = None

    async def wait(self) -> int:
        assert self._life is not None
        try:
            return await asyncio.shield(self._life)
        except asyncio.CancelledError:
            if not self._life.cancelled():
                raise
            return -signal.SIGKILL

    def follow(self, on_step: Callable[[str], None]) -> None:
        self.on_step = on_step

    def look(self) -> None:
        while self.unseen:
            self.on_step(self.unseen.pop(0))

    def forget_steps(self) -> None:
        self.unseen.clear()

    def end(self, number: signal.Signals) -> None:
        if number == signal.SIGKILL and self._life is not None and not self._life.done():
            self.killed_s.append(asyncio.get_running_loop().time())
        if self._life is not None:
            self._life.cancel()

    def note(self, text: str) -> None:
        self.log.append(text)

    def tail(self) -> str:
        return "\n".join(self.log)

    async def work(self, *steps_s: float) -> None:
        """Get on after each of these times."""
        for number, step_s in enumerate(steps_s):
            await asyncio.sleep(step_s)
            self.on_step(f"step {number}")

    async def get_ready(self) -> None:
        joined = asyncio.ensure_future(self.bench.answer("join", {"process": self.name, "pid": self.pid}))
        await joined
        self.bench.on_ready(self.name, {"pid": self.pid})


async def live_for_ever(process: PlayedProcess) -> int:
    await process.get_ready()
    await asyncio.Event().wait()
    return 0


async def hang(_process: PlayedProcess) -> int:
    await asyncio.Event().wait()
    return 0


class Bench:
    """`wires` is a hub, `lamp` a device on it: each a process."""

    def __init__(self, **lives: list[Life]) -> None:
        config = from_dict(
            {
                "time": "real",
                "name": "lab",
                "start_timeout_s": LIMIT_S,
                "buses": {"wires": {"kind": "wires.hub", "process": "wires"}},
                "devices": {"lamp": {"kind": "rig_kinds:Adder", "links": {"wires": "wires"}}},
            },
            HERE,
        )
        self.events: list[Event] = []
        self.heard: dict[str, Callable[[str, Any], None]] = {}
        self.answer: Callable[[str, Any], Any]
        self.asked: list[tuple[str, Any]] = []
        """The questions to the processes."""
        self.hangs = False
        self.answers: dict[str, Any] = {}
        """Their answers, by the path of the question."""
        plans = placement(config)
        self.by_name = {name: PlayedProcess(self, name, lives.get(name, [live_for_ever])) for name in plans}
        self.supervisor = Supervisor(config, plans, cast(Control, self), cast(Children, self), self.events.append)

    def serve(self, _path: str, answer: Any) -> None:
        self.answer = answer

    def listen_to(self, path: str, handler: Any) -> None:
        self.heard[path.removesuffix("/*")] = handler

    def on_ready(self, name: str, message: Any) -> None:
        self.heard["ready"](name, message)

    def publish(self, path: str, message: Any) -> None:
        pass

    def limits(self) -> dict[str, float]:
        return {}

    async def ask(self, path: str, message: Any, _timeout_s: float) -> Any:
        self.asked.append((path, message))
        if self.hangs:
            raise NoAnswerError("lamp does not answer")
        return self.answers.get(path, {})

    @property
    def lamp(self) -> PlayedProcess:
        return self.by_name["lamp"]

    def texts(self, what: str) -> list[str]:
        return [event.text for event in self.events if event.what == what and event.process]


def run(until_s: float, refusals: int = 0, **lives: list[Life]) -> tuple[Bench, Exit]:
    """Run the rig for at most this number of seconds.  The system refuses this number of restarts of the lamp."""

    async def rig() -> tuple[Bench, Exit]:
        bench = Bench(**lives)
        bench.lamp.refusals = refusals
        asyncio.get_running_loop().call_later(until_s, bench.supervisor.end)
        return bench, await bench.supervisor.run()

    return run_jumping(rig())


def test_a_process_that_gets_on_is_waited_for_however_long_it_takes() -> None:
    async def slow(process: PlayedProcess) -> int:
        await process.work(*[0.9 * LIMIT_S] * 20)
        return await live_for_ever(process)

    bench, code = run(1000, lamp=[slow])
    assert code == Exit.OK
    assert bench.lamp.started_s == [0.0]
    assert "lamp" in [event.process for event in bench.events if event.what == "ready"]


def test_at_the_start_a_process_without_progress_ends_the_rig_and_the_message_says_what_to_set() -> None:
    async def stuck(process: PlayedProcess) -> int:
        await process.work(1.0)
        return await hang(process)

    bench, code = run(1000, lamp=[stuck])
    assert code == Exit.DEVICE_FAILED
    (text,) = bench.texts("failed")
    assert text.startswith("made no progress while it started: for 10 s (its last step: step 0)")
    assert "start_timeout_s: 20" in text


@pytest.mark.parametrize(("state", "expected"), [("ready", Exit.OK), ("starting", Exit.DEVICE_FAILED)])
def test_a_process_whose_word_that_it_is_ready_was_lost_is_asked(state: str, expected: Exit) -> None:
    """On a busy host a message may be lost, and the process that had sent it was killed as one that hangs."""

    async def unheard(process: PlayedProcess) -> int:
        process.bench.answers["process/lamp/status"] = {"state": state, "pid": process.pid}
        await process.bench.answer("join", {"process": process.name, "pid": process.pid})
        process.on_step("ready")
        return await hang(process)

    bench, code = run(5 * LIMIT_S, lamp=[unheard])
    assert code == expected
    assert [path for path, _ in bench.asked] == ["process/lamp/status"]
    assert ("lamp" in [event.process for event in bench.events if event.what == "ready"]) is (expected is Exit.OK)


async def die(process: PlayedProcess) -> int:
    await process.get_ready()
    return CRASHED


def test_the_limit_doubles_with_each_restart_of_a_process_that_gets_nowhere() -> None:
    bench, _ = run(1000, lamp=[die, hang, hang, hang, live_for_ever])
    lasted_s = [killed - begun for begun, killed in zip(bench.lamp.started_s[1:], bench.lamp.killed_s, strict=False)]
    assert lasted_s == pytest.approx([20.0, 40.0, 80.0])
    assert len(bench.lamp.started_s) == 5


def test_a_late_process_is_reported_with_its_last_step_and_a_remedy_and_its_log_has_it_too() -> None:
    async def stuck(process: PlayedProcess) -> int:
        await process.work(1.0, 1.0)
        return await hang(process)

    bench, _ = run(1000, lamp=[die, stuck, live_for_ever])
    (text,) = bench.texts("late")
    assert text == (
        "made no progress while it started: for 20 s (its last step: step 1); killing it\n"
        "on a busy host set start_timeout_s: 40 in the rig file, or by --set"
    )
    assert bench.lamp.log[1] == f"late: {text}"
    assert bench.lamp.log[2] == "died: killed by SIGKILL; starting it again"


def test_a_process_that_has_settled_begins_with_the_normal_limit_again() -> None:
    async def settle_then_die(process: PlayedProcess) -> int:
        await process.get_ready()
        await asyncio.sleep(2 * SETTLED_S)
        return CRASHED

    bench, _ = run(1000, lamp=[die, hang, settle_then_die, hang, live_for_ever])
    lasted_s = [killed - bench.lamp.started_s[life] for life, killed in zip((1, 3), bench.lamp.killed_s, strict=False)]
    assert lasted_s == pytest.approx([2 * LIMIT_S, LIMIT_S])


def test_steps_reported_while_the_supervisor_was_blocked_count() -> None:
    async def unseen(process: PlayedProcess) -> int:
        process.unseen.append("building lamp")
        await asyncio.sleep(1.5 * LIMIT_S)
        return await live_for_ever(process)

    bench, code = run(1000, lamp=[unseen])
    assert code == Exit.OK
    assert bench.lamp.started_s == [0.0]


def test_a_device_is_not_late_while_the_hub_that_it_attaches_to_is_being_restarted() -> None:
    async def die_later(process: PlayedProcess) -> int:
        await process.get_ready()
        await asyncio.sleep(100)
        return CRASHED

    async def come_back_slowly(process: PlayedProcess) -> int:
        await process.work(*[0.9 * LIMIT_S] * 10)
        return await live_for_ever(process)

    async def attach_slowly(process: PlayedProcess) -> int:
        await process.bench.answer("join", {"process": process.name, "pid": process.pid})
        await asyncio.sleep(80)  # no hub answers meanwhile
        return await live_for_ever(process)

    async def die_a_little_before(process: PlayedProcess) -> int:
        await process.get_ready()
        await asyncio.sleep(99)
        return CRASHED

    bench, _ = run(1000, wires=[die_later, come_back_slowly], lamp=[die_a_little_before, attach_slowly])
    assert bench.texts("late") == []
    assert len(bench.lamp.started_s) == 2


@pytest.mark.parametrize(
    ("name", "hangs", "begun"), [("lamp", False, (1, 1)), ("lamp", True, (1, 2)), ("wires", False, (2, 1))]
)
def test_a_device_is_switched_off_and_on_and_a_bus_and_a_process_that_hangs_are_started_again(
    name: str, hangs: bool, begun: tuple[int, int]
) -> None:
    async def rig() -> Bench:
        bench = Bench(wires=[live_for_ever, live_for_ever], lamp=[live_for_ever, live_for_ever])
        bench.hangs = hangs
        asyncio.get_running_loop().call_later(200, bench.supervisor.end)
        running = asyncio.ensure_future(bench.supervisor.run())
        await asyncio.sleep(100)
        restarted = await bench.answer("restart", {"name": name})
        assert restarted == ({"device": name} if begun == (1, 1) else {"process": name})
        await running
        return bench

    bench = run_jumping(rig())
    assert tuple(len(bench.by_name[process].started_s) for process in ("wires", "lamp")) == begun
    assert bench.asked == ([("process/lamp/restart", {"device": "lamp"})] if name == "lamp" else [])


def test_a_process_that_hangs_is_killed_when_it_is_to_be_started_again() -> None:
    async def hear_nothing(process: PlayedProcess) -> int:
        await process.get_ready()
        with suppress(asyncio.CancelledError):
            await asyncio.Event().wait()
        return await hang(process)

    async def rig() -> Bench:
        bench = Bench(lamp=[hear_nothing, live_for_ever])
        bench.hangs = True
        asyncio.get_running_loop().call_later(200, bench.supervisor.end)
        running = asyncio.ensure_future(bench.supervisor.run())
        await asyncio.sleep(100)
        await bench.answer("restart", {"name": "lamp"})
        await running
        return bench

    lamp = run_jumping(rig()).lamp
    assert lamp.killed_s[0] == lamp.started_s[1] == 100 + GRACE_S


def test_a_restart_that_the_system_refuses_is_tried_again_until_it_succeeds_and_is_told_once() -> None:
    bench, code = run(1000, refusals=20, lamp=[die, live_for_ever])
    assert code == Exit.OK
    assert bench.texts("late") == ["it cannot be started: Too many open files; trying again until it can"]
    pauses_s = [later - earlier for earlier, later in zip(bench.lamp.asked_s[1:], bench.lamp.asked_s[2:], strict=False)]
    assert len(pauses_s) == 20
    assert FIRST_PAUSE_S < min(pauses_s) <= max(pauses_s) == pytest.approx(LONGEST_PAUSE_S)
    assert [event.process for event in bench.events if event.what == "ready"].count("lamp") == 2


def test_a_rig_ends_while_a_restart_is_refused() -> None:
    bench, code = run(20, refusals=1000, lamp=[die, live_for_ever])
    assert (code, len(bench.lamp.started_s)) == (Exit.OK, 1)


def test_patience_grows_to_a_bound_and_not_below_what_the_rig_file_asks_for() -> None:
    patience = Patience(LIMIT_S)
    pauses_s = [patience.after_death(0.0) for _ in range(20)]
    assert pauses_s[:3] == [FIRST_PAUSE_S, 2 * FIRST_PAUSE_S, 4 * FIRST_PAUSE_S]
    assert pauses_s[-1] == LONGEST_PAUSE_S
    assert patience.limit_s == LONGEST_LIMIT_S
    generous = Patience(3 * LONGEST_LIMIT_S)
    generous.after_death(0.0)
    assert generous.limit_s == 3 * LONGEST_LIMIT_S
