"""The processes of a rig under real time and their states: what `status` shows and `join` waits for.

Processes are started by a supervisor, or from outside, as containers are, and then connect here.  In both cases they
ask to `join` when their hubs are open, and are answered when the processes that they wait for are ready.
"""

import asyncio
import time
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from fieldrig.config.rig_file import RigConfig
from fieldrig.control.events import Event, event
from fieldrig.control.messages import Control
from fieldrig.control.question_words import asked
from fieldrig.control.rig_status import rig_status
from fieldrig.errors import ControlError
from fieldrig.real.placement import ProcessPlan
from fieldrig.text.nearest import closest


class ProcessState(StrEnum):
    STARTING = "starting"
    WAITING = "waiting"
    RELEASED = "released"
    READY = "ready"
    DEAD = "dead"
    GONE = "gone"


OPEN = frozenset({ProcessState.WAITING, ProcessState.RELEASED, ProcessState.READY})
"""The states in which a process's hubs can be attached to."""
ON_ITS_WAY = frozenset({ProcessState.STARTING, ProcessState.WAITING, ProcessState.RELEASED})


GREETING_S = 5.0
ANSWER_S = 3.0
"""How long a process may take to answer before it counts as one that hangs; tools wait for 5 s themselves."""


Report = Callable[[Event], None]
Verb = Callable[[Any], Awaitable[Any]]


@dataclass(eq=False)
class Member:
    """One process as the rig sees it."""

    plan: ProcessPlan
    state: ProcessState = ProcessState.STARTING
    pid: int | None = None
    restarts: int = 0
    step: str = ""
    """How far the process has come with its start, as far as the supervisor knows."""
    since_s: float = field(default_factory=time.monotonic)
    """When the process was last started, or connected."""
    released: asyncio.Event = field(default_factory=asyncio.Event)

    @property
    def name(self) -> str:
        return self.plan.name

    def age_s(self) -> float:
        return time.monotonic() - self.since_s


class Roster:
    def __init__(self, config: RigConfig, plans: dict[str, ProcessPlan], control: Control, report: Report) -> None:
        self.members = {name: Member(plan) for name, plan in plans.items()}
        self.was_ready = False
        self.on_change: Callable[[Member], None] = lambda _member: None
        self.beside: Callable[[], Mapping[str, Any]] = dict
        """Returns what `status` also shows: what runs beside the rig."""
        self._config, self._control, self._report = config, control, report
        self._verbs: dict[str, Verb] = {}
        self._epoch_ns = time.time_ns() - time.monotonic_ns()
        self._started_s = time.monotonic()
        self._is_stopping = False
        self._late: dict[str, str] = {}
        """The processes for which the host is late, with the words for it."""
        self._greetings: set[asyncio.Task[None]] = set()

    def serve(self, **verbs: Verb) -> None:
        """Answer `status`, `join`, and the given verbs."""
        self._verbs = verbs
        self._control.listen_to("ready/*", self._on_ready)
        self._control.listen_to("warning/*", self._on_warning)
        self._control.listen_to("late/*", self._on_late)
        self._control.serve("rig/*", self._answer)
        if not self.members:
            self._on_all_ready()

    def watch(self) -> None:
        """Watch the signs of life of processes that are started from outside."""
        self._control.watch_life("alive/*", self._on_life)

    def member_of(self, name: str) -> Member:
        """Return the process of that name, or that of the device or bus of that name.

        ControlError if there is none.
        """
        for member in self.members.values():
            if name == member.name or name in member.plan.buses or name in member.plan.devices:
                return member
        parts = [part for plan in (member.plan for member in self.members.values()) for part in _names_in(plan)]
        raise ControlError(
            f"this rig has no process, device or bus {name!r}", closest(name, list(dict.fromkeys(parts)))
        )

    async def power_cycle(self, device: str) -> None:
        """Switch a device of a process that is ready off and on again, at one instant.

        NoAnswerError if its process hangs; ControlError if a fault has switched the device off.
        """
        await self._control.ask(f"process/{self.member_of(device).name}/restart", {"device": device}, ANSWER_S)

    def set_state(self, member: Member, state: ProcessState) -> None:
        member.state = state
        if state is ProcessState.STARTING:
            member.since_s = time.monotonic()
        elif state in (ProcessState.DEAD, ProcessState.GONE):
            member.pid = None
            member.released.set()
            self._set_late(member.name, "")
        self.on_change(member)
        self._settle()

    def publish(self, what: str, process: str = "", text: str = "") -> None:
        happened = event(what, process, text)
        self._report(happened)
        self._control.publish("event", happened._asdict())

    def stop(self) -> None:
        self._is_stopping = True
        self.publish("stopping")

    def status(self) -> dict[str, Any]:
        return {
            **rig_status(self._config, self._control, self._started_s, lambda device: device.process),
            "run": str(self._config.run.absolute()),
            "state": self._state(),
            "late": dict(self._late),
            "processes": {name: _shown(member) for name, member in self.members.items()},
            **self.beside(),
        }

    @property
    def is_ready(self) -> bool:
        """True if every process that is still part of the rig is ready."""
        return self._state() == "ready"

    def _state(self) -> str:
        if self._is_stopping:
            return "stopping"
        states = {member.state for member in self.members.values()} - {ProcessState.GONE}
        if states <= {ProcessState.READY}:
            return "ready"
        return "degraded" if self.was_ready else "starting"

    async def _answer(self, verb: str, message: Any) -> Any:
        if verb == "status":
            return self.status()
        if verb == "join":
            return await self._join(message)
        if verb not in self._verbs:
            raise ControlError(
                f"this rig cannot {'go back' if verb == 'back' else verb}",
                f"it can: {', '.join(['status', *self._verbs])}; others need time: virtual",
            )
        return await self._verbs[verb](message) or {}

    async def _join(self, message: Any) -> dict[str, Any]:
        """Answer when the process may attach and start its devices."""
        match message:
            case {"process": str(name), "pid": int(pid)} if name in self.members:
                member = self.members[name]
            case _:
                raise ControlError(f"this rig cannot {asked('join', message)}", f"it has: {', '.join(self.members)}")
        member.pid = pid
        released = member.released = asyncio.Event()
        self.set_state(member, ProcessState.WAITING)
        await released.wait()
        return {"epoch_ns": self._epoch_ns}

    def _settle(self) -> None:
        """Release the processes whose wait is over, which may end the wait of others."""
        for member in self.members.values():
            if member.state is ProcessState.WAITING and self._may_start(member.plan):
                member.state = ProcessState.RELEASED
                member.released.set()
                self.on_change(member)

    def _may_start(self, plan: ProcessPlan) -> bool:
        if any(self.members[other].state not in OPEN for other in plan.attaches):
            return False
        if self.was_ready:  # one that died permanently is not waited for
            return all(self.members[other].state not in ON_ITS_WAY for other in plan.after)
        return all(self.members[other].state is ProcessState.READY for other in plan.after)

    def _on_ready(self, name: str, message: Any) -> None:
        member = self.members.get(name)
        if member is None or member.state is ProcessState.READY or message != {"pid": member.pid}:
            return
        self.set_state(member, ProcessState.READY)
        self.publish("ready", name)
        if all(other.state in (ProcessState.READY, ProcessState.GONE) for other in self.members.values()):
            self._on_all_ready()

    def _on_warning(self, name: str, message: Any) -> None:
        match message:
            case {"text": str(text)} if name in self.members:
                self.publish("warning", name, text)

    def _on_late(self, name: str, message: Any) -> None:
        """Tell the begin and the end of a time in which the host is late, whichever processes are late then."""
        match message:
            case {"words": str(words)} if name in self.members:
                self._set_late(name, words)

    def _set_late(self, name: str, words: str) -> None:
        was_late = bool(self._late)
        if words:
            self._late[name] = words
        else:
            self._late.pop(name, None)
        if bool(self._late) is not was_late:
            self.publish("warning", name, f"the host is late: {words}" if words else "the host is on time again")

    def _on_all_ready(self) -> None:
        if not self.was_ready:
            self.was_ready = True
            self.publish("ready")

    def _on_life(self, name: str, is_alive: bool) -> None:
        member = self.members.get(name)
        if member is None:
            return
        if not is_alive:
            self.set_state(member, ProcessState.DEAD)
            self.publish("gone", name, "its process ended, or lost its way here")
        elif member.state is ProcessState.WAITING:
            return
        # It may have joined a rig that was here before this one; or be here again, as on a busy host the end of its
        # former connection can be heard after the begin of this one.
        self.greet(member)

    def greet(self, member: Member) -> None:
        """Ask a process for its state, as it may have become ready without a word that was heard here."""
        greeting = asyncio.get_running_loop().create_task(self._greet(member))
        self._greetings.add(greeting)
        greeting.add_done_callback(self._greetings.discard)

    async def _greet(self, member: Member) -> None:
        with suppress(ControlError):  # it died in the meantime
            status = await self._control.ask(f"process/{member.name}/status", None, GREETING_S)
            if status["state"] == "ready":
                member.pid = status["pid"]
                self._on_ready(member.name, {"pid": member.pid})


def _names_in(plan: ProcessPlan) -> tuple[str, ...]:
    return plan.name, *plan.buses, *plan.devices


def _shown(member: Member) -> dict[str, Any]:
    plan = member.plan
    return {
        "state": member.state,
        "pid": member.pid,
        "uptime_s": round(member.age_s(), 3) if member.pid is not None else None,
        "restarts": member.restarts,
        "step": member.step if member.state in ON_ITS_WAY else "",
        "on_exit": plan.on_exit,
        "buses": plan.buses,
        "devices": plan.devices,
    }
