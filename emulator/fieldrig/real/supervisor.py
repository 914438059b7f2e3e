"""Runs the processes of a rig under real time: starts, monitors, restarts and ends them.

All are started at once; each loads its part of the rig, opens its hubs and asks to `join`.  The answer is held back
until the processes that it waits for are ready, so messages determine the order, not delays.  A process that ends
before the whole rig is ready ends the start; later its `on_exit` decides.  A starting process is waited for as long as
it makes progress.  Without progress for `start_timeout_s` it is killed, and has twice as long when it is restarted
(`patience`).
"""

import asyncio
import signal
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from fieldrig.config.rig_file import RigConfig
from fieldrig.control.messages import Control, NoAnswerError
from fieldrig.control.question_words import asked
from fieldrig.errors import ControlError
from fieldrig.real.child import how_it_ended, why_it_ended
from fieldrig.real.children import Children
from fieldrig.real.patience import Patience
from fieldrig.real.placement import ProcessPlan
from fieldrig.real.progress import READY
from fieldrig.real.roster import OPEN, Member, ProcessState, Report, Roster
from fieldrig.system.exits import KILL, Exit

GRACE_S = 3.0
"""Time between SIGTERM and SIGKILL."""
HEARD_S = 2.0
"""Time from the last step of a process within which its word that it is ready is heard."""


class Supervisor:
    def __init__(
        self, config: RigConfig, plans: dict[str, ProcessPlan], control: Control, children: Children, report: Report
    ) -> None:
        """Make the supervisor of the processes `plans`; it starts nothing before `run`.

        `children` are the same processes, by their names.  Those that were forked already are taken over, and the
        others are spawned.  `report` gets what a user should see of starts, ends and restarts.
        """
        self.roster = Roster(config, plans, control, report)
        self._patience = {name: Patience(config.start_timeout_s) for name in plans}
        self._ready_at_s: dict[str, float] = {}
        """The loop's time at which each process became ready; only of processes that are ready."""
        self._ended: asyncio.Future[Exit] = asyncio.get_running_loop().create_future()
        self._at_once = asyncio.Event()
        self._children = children.by_name
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._wanted_restarts: set[str] = set()
        self._tenders: dict[str, asyncio.Task[None]] = {}

    @property
    def beside(self) -> Callable[[], Mapping[str, Any]]:
        """The function that returns the facts about what runs beside the rig, for `status`."""
        return self.roster.beside

    @beside.setter
    def beside(self, facts: Callable[[], Mapping[str, Any]]) -> None:
        self.roster.beside = facts

    async def run(self) -> Exit:
        """Run until `end` is called, or until a process fails in a way that ends the rig."""
        roster = self.roster
        roster.on_change = self._on_change
        roster.serve(stop=self._on_stop_asked, restart=self._on_restart_asked)
        loop = asyncio.get_running_loop()
        try:
            for name, member in roster.members.items():
                await self._begin(member)
                tender = self._tenders[name] = loop.create_task(self._tend(member))
                tender.add_done_callback(self._on_tender_done)
            return await self._ended
        finally:
            await self._end_all()

    def end(self, code: Exit = Exit.OK) -> None:
        """End in order; a second call ends at once."""
        if self._ended.done():
            self._at_once.set()
        else:
            self._ended.set_result(code)

    async def _tend(self, member: Member) -> None:
        """Wait for the end of one process, and restart it or end the rig, over and over."""
        patience = self._patience[member.name]
        while True:
            code = await self._children[member.name].wait()
            self._forget_timer(member.name)
            self._children[member.name].forget_steps()
            ready_s = self._ready_s(member)
            self.roster.set_state(member, ProcessState.DEAD)
            if self._ended.done():
                return
            if member.name in self._wanted_restarts:
                self._wanted_restarts.discard(member.name)
            elif not self._goes_on_after(member, code):
                return
            else:
                pause_s = patience.after_death(ready_s)
                self._note(member, "died", f"{self._why(member, code)}; starting it again")
                await asyncio.wait({self._ended}, timeout=pause_s)
            if self._ended.done():
                return
            member.restarts += 1
            await self._begin_again(member)
            if self._ended.done():
                return

    async def _begin_again(self, member: Member) -> None:
        """Start a process again, and if the system has no descriptor, process or memory for it, later."""
        had_trouble = False
        while not self._ended.done():
            try:
                await self._begin(member)
            except OSError as cause:
                self.roster.set_state(member, ProcessState.DEAD)
                if not had_trouble:
                    why = cause.strerror or cause
                    self._note(member, "late", f"it cannot be started: {why}; trying again until it can")
                had_trouble = True
                await asyncio.wait({self._ended}, timeout=self._patience[member.name].after_death(0.0))
            else:
                return

    def _ready_s(self, member: Member) -> float:
        """Return how long the process has been ready; 0 if it is not."""
        ready_at_s = self._ready_at_s.pop(member.name, None)
        return 0.0 if ready_at_s is None else asyncio.get_running_loop().time() - ready_at_s

    def _note(self, member: Member, what: str, text: str) -> None:
        """Publish an event, and add it to the log of the process."""
        self.roster.publish(what, member.name, text)
        self._children[member.name].note(f"{what}: {text}")

    def _on_tender_done(self, tender: asyncio.Task[None]) -> None:
        """End the rig for a fault in this task, so that no process is left without supervision."""
        cause = tender.exception()
        if cause is not None and not self._ended.done():
            self._ended.set_exception(cause)

    def _goes_on_after(self, member: Member, code: int) -> bool:
        """Return whether the process is to be restarted."""
        roster, name = self.roster, member.name
        if not roster.was_ready:
            self._fail_start(member, f"ended while it started: {how_it_ended(code)}", _exit_of_start(code))
        elif member.plan.on_exit == "stop":
            roster.publish("failed", name, f"{how_it_ended(code)}; the rig stops\n{self._children[name].tail()}")
            self.end(Exit.DEVICE_FAILED)
        elif member.plan.on_exit == "ignore":
            roster.set_state(member, ProcessState.GONE)
            roster.publish("gone", name, f"{self._why(member, code)}; the rig goes on without it")
        else:
            return True
        return False

    def _why(self, member: Member, code: int) -> str:
        return why_it_ended(code, self._children[member.name].tail())

    def _fail_start(self, member: Member, how: str, code: Exit) -> None:
        """End the start with this failure.  Later failures do not count, as they follow from the first."""
        if not self._ended.done():
            log = self._children[member.name].tail() or "(it wrote nothing)"
            self.roster.publish("failed", member.name, f"{how}\n{log}")
            self.end(code)

    async def _begin(self, member: Member) -> None:
        child = self._children[member.name]
        member.step = "starting Python"
        self.roster.set_state(member, ProcessState.STARTING)
        if child.pid is None:
            await child.spawn()
        member.pid = child.pid
        child.follow(partial(self._on_step, member))

    def _on_step(self, member: Member, step: str) -> None:
        """Note the progress of a starting process."""
        member.step = step
        self._be_patient(member)
        if step == READY:
            asyncio.get_running_loop().call_later(HEARD_S, self._ask_if_ready, member)

    def _ask_if_ready(self, member: Member) -> None:
        """Ask a process for its state whose last word was not heard: on a busy host a message may be lost."""
        if member.state is ProcessState.RELEASED and not self._ended.done():
            self.roster.greet(member)

    def _on_change(self, member: Member) -> None:
        if member.state is ProcessState.READY:
            self._ready_at_s[member.name] = asyncio.get_running_loop().time()
        self._be_patient(member)

    def _be_patient(self, member: Member) -> None:
        """Restart the time limit while a process works on its start; remove it while the process waits for others."""
        self._forget_timer(member.name)
        if member.state in (ProcessState.STARTING, ProcessState.RELEASED) and not self._ended.done():
            loop, limit_s = asyncio.get_running_loop(), self._patience[member.name].limit_s
            self._timers[member.name] = loop.call_later(limit_s, self._lose_patience, member)

    def _lose_patience(self, member: Member) -> None:
        timer = self._timers[member.name]
        self._children[member.name].look()  # this process may have stood still longer than the other one
        if self._timers[member.name] is not timer:
            return
        if member.state is ProcessState.RELEASED and self._waits_for_a_hub(member):
            self._be_patient(member)
            return
        patience = self._patience[member.name]
        how = f"made no progress while it started: for {patience.limit_s:g} s (its last step: {member.step})"
        if self.roster.was_ready:
            self._note(member, "late", f"{how}; killing it\n{patience.advice}")
            self._children[member.name].end(KILL)
        else:
            self._fail_start(member, f"{how}; {patience.advice}", Exit.DEVICE_FAILED)

    def _waits_for_a_hub(self, member: Member) -> bool:
        """Return whether a hub that the process attaches to has died."""
        return any(self.roster.members[other].state not in OPEN for other in member.plan.attaches)

    def _forget_timer(self, name: str) -> None:
        timer = self._timers.pop(name, None)
        if timer is not None:
            timer.cancel()

    async def _on_stop_asked(self, _message: Any) -> None:
        self.end()

    async def _on_restart_asked(self, message: Any) -> dict[str, str]:
        """Switch a device off and on; a process, that of a bus, and that of a device which hangs, are started again."""
        match message:
            case {"name": str(name)}:
                member = self.roster.member_of(name)
            case _:
                raise ControlError(
                    f"this rig cannot {asked('restart', message)}", "expected the name of a device, bus or process"
                )
        if self._tenders[member.name].done():
            raise ControlError(f"{member.name} has ended and will not be restarted", "stop the rig and start it again")
        if name in member.plan.devices and member.state is ProcessState.READY:
            with suppress(NoAnswerError):
                await self.roster.power_cycle(name)
                return {"device": name}
        child = self._children[member.name]
        self._wanted_restarts.add(member.name)
        child.end(signal.SIGTERM)
        self._forget_timer(member.name)
        self._timers[member.name] = asyncio.get_running_loop().call_later(GRACE_S, child.end, KILL)
        return {"process": member.name}

    async def _end_all(self) -> None:
        """End all processes, those without hubs first, so that their last messages still arrive."""
        for name in tuple(self._timers):
            self._forget_timer(name)
        self.roster.stop()
        hurry = asyncio.get_running_loop().create_task(self._at_once.wait())
        hubs = {name for name, member in self.roster.members.items() if member.plan.buses}
        for wave in (self._tenders.keys() - hubs, hubs & self._tenders.keys()):
            for name in wave:
                self._children[name].end(signal.SIGTERM)
            await _all_done([self._tenders[name] for name in wave], hurry)
        for child in self._children.values():
            child.end(KILL)
        await asyncio.gather(*self._tenders.values(), return_exceptions=True)  # `run` raises the first of them
        hurry.cancel()
        with suppress(asyncio.CancelledError):
            await hurry
        self.roster.publish("stopped")


async def _all_done(tasks: Sequence[asyncio.Task[None]], hurry: asyncio.Task[bool]) -> None:
    """Wait until all have ended, the time is over, or `end` is called again."""
    loop = asyncio.get_running_loop()
    give_up_s = loop.time() + GRACE_S
    waiting: set[asyncio.Task[None]] = {task for task in tasks if not task.done()}
    while waiting and not hurry.done() and (left_s := give_up_s - loop.time()) > 0:
        await asyncio.wait({*waiting, hurry}, timeout=left_s, return_when=asyncio.FIRST_COMPLETED)
        waiting = {task for task in waiting if not task.done()}


def _exit_of_start(code: int) -> Exit:
    return Exit(code) if code in (Exit.WRONG, Exit.CANNOT_START) else Exit.DEVICE_FAILED
