"""A rig in virtual time under `fieldrig up`: paced, paused, stepped, and controlled by messages.

The rig runs in slices of `SLICE_S`, so that it answers questions even at full speed.
"""

import asyncio
import os
import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import NEVER_NS, S
from fieldrig.config.rig_file import RigConfig
from fieldrig.control.bus_questions import answers_of_bus
from fieldrig.control.device_questions import answers
from fieldrig.control.events import event
from fieldrig.control.messages import Control
from fieldrig.control.notices import Watched, look_on
from fieldrig.control.question_words import asked
from fieldrig.control.rig_status import rig_status
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.hub.bus_stream import BusStream, OnDelivery
from fieldrig.real.roster import ProcessState, Report
from fieldrig.recording.recorders import Recorders
from fieldrig.system.exits import Exit
from fieldrig.system.this_process import brief_facts, facts
from fieldrig.virtual.recorded import RigSource
from fieldrig.virtual.rig import Rig

SLICE_S = 0.01
"""Length of a slice in real time."""
FASTEST = 1e9
"""Largest speed in times of real time; faster than any host."""
BEHIND_S = 0.5
"""Largest lag; a rig that lags further gives up the lost time."""


class _Part:
    """A bus or a device of the rig."""

    def __init__(self, rig: Rig, name: str) -> None:
        self._rig, self._name = rig, name

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        return self._rig.add_fault(self._name, fault)

    def clear_fault(self, number: int) -> None:
        self._rig.clear_fault(self._name, number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        return self._rig.faults(self._name)


class VirtualPoints(_Part):
    def facts(self) -> Mapping[str, Any]:
        return self._rig.facts(self._name)

    def values(self, keys: Iterable[str] | None = None) -> Mapping[str, Value]:
        return self._rig.values(self._name, keys)

    def front(self) -> Mapping[str, Any]:
        return self._rig.front(self._name)

    def set(self, key: str, value: Value) -> None:
        self._rig.set(self._name, key, value)

    def answer(self, question: str, message: Any) -> Any:
        return self._rig.answer(self._name, question, message)


class VirtualBus(_Part):
    def statistics(self) -> dict[str, float]:
        return self._rig.statistics(self._name)

    def conditions(self) -> Mapping[str, str]:
        return self._rig.conditions(self._name)

    def signals(self) -> Mapping[str, Mapping[str, Any]]:
        return self._rig.signals(self._name)


class VirtualService:
    def __init__(self, config: RigConfig, control: Control, report: Report) -> None:
        self.beside: Callable[[], Mapping[str, Any]] = dict
        """Returns what `status` also shows: what runs beside the rig."""
        self._config, self._control, self._report = config, control, report
        self._loop = asyncio.get_running_loop()
        self._ended: asyncio.Future[Exit] = self._loop.create_future()
        self._may_run = asyncio.Event()
        self._may_run.set()
        self._listeners: dict[str, OnDelivery] = {}
        self._end_listening: Callable[[], None] | None = None
        """Ends the call for every delivery, while there is a listener."""
        self._speed = config.speed
        self._started_s = time.monotonic()
        self._base_s = self._loop.time()  # virtual time is paced from here: the host's time, and ours at that time
        self._base_ns = 0

    async def run(self) -> Exit:
        """Run until `end` is called.  RigError if a device cannot be built, or devices answer each other endlessly."""
        with Rig(self._config) as self._rig:
            self._serve()
            await asyncio.sleep(0)  # what can be reached is printed meanwhile, before it is ready
            self._rebase()
            self.publish("ready")
            pacer = self._loop.create_task(self._pace())
            looking = self._loop.create_task(look_on(self._control, self._watched, lambda: self._rig.now_ns))
            both: set[asyncio.Future[Any]] = {pacer, self._ended}
            await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
            self.publish("stopping")
            looking.cancel()
            if not pacer.done():
                pacer.cancel()
                await asyncio.wait({pacer})
            for stream in self._streams:
                stream.flush()
            self._recorders.close()
            if not pacer.cancelled():
                pacer.result()
        return self._ended.result()

    def end(self) -> None:
        if not self._ended.done():
            self._ended.set_result(Exit.OK)

    def publish(self, what: str, text: str = "") -> None:
        happened = event(what, "", text)
        self._report(happened)
        self._control.publish("event", happened._asdict())

    def _serve(self) -> None:
        control, rig = self._control, self._rig
        self._streams = [
            BusStream(control, bus, self._config.name, partial(self._listen, bus.name)) for bus in rig.buses.values()
        ]
        self._watched: list[Watched] = []
        for bus in rig.buses:
            subject = VirtualBus(rig, bus)
            control.serve(f"bus/{bus}/*", answers_of_bus(subject))
            self._watched.append(Watched(bus, subject.faults, subject.conditions))
        for device in self._config.devices:
            points = VirtualPoints(rig, device)
            control.serve(f"device/{device}/*", answers(points))
            self._watched.append(Watched(device, points.faults))
        self._recorders = Recorders(control, self._config.name, RigSource(rig), is_lossless=True)
        control.serve(f"process/{self._config.name}/status", self._process_status)
        control.serve(f"process/{self._config.name}/brief", self._brief)
        control.serve("rig/*", self._answer)

    async def _answer(self, verb: str, message: Any) -> Any:
        match verb, message:
            case "status", _:
                return self._status()
            case "stop", _:
                self.end()
            case "pause", _:
                self._may_run.clear()
            case "run", {"speed": int() | float() | None as speed} if speed is None or 0 < speed <= FASTEST:
                self._speed = speed
                self._rebase()
                self._may_run.set()
            case "run", None:
                self._rebase()
                self._may_run.set()
            case "step", {"ns": int(duration_ns)} if 0 <= duration_ns < NEVER_NS - self._rig.now_ns:
                self._may_run.clear()
                await self._run_until(self._rig.now_ns + duration_ns)
            case "restart", {"name": str(name)}:
                self._rig.restart(name)
            case _:
                remedy = "it can: status, stop, pause, run, step, restart"
                raise ControlError(f"this rig cannot {asked(verb, message)}", remedy)
        return {"now_ns": self._rig.now_ns, "is_paused": not self._may_run.is_set()}

    async def _pace(self) -> None:
        while True:
            if not self._may_run.is_set():
                await self._may_run.wait()
                self._rebase()
            await self._recorders.until_room()
            if self._speed is None:
                await self._run_until_asked()
                continue
            elapsed_s = self._loop.time() - self._base_s
            target_ns = self._base_ns + round(elapsed_s * self._speed * S)
            if self._slice(target_ns):
                await asyncio.sleep(SLICE_S)
            else:
                await asyncio.sleep(0)
                if target_ns - self._rig.now_ns > BEHIND_S * self._speed * S:
                    self._rebase()

    async def _run_until_asked(self) -> None:
        """Run at full speed; a rig in which nothing ever happens stands still."""
        next_ns = self._rig.next_ns()
        if next_ns is None:
            await asyncio.sleep(SLICE_S)
        else:
            self._slice(None)
            await asyncio.sleep(0)

    async def _run_until(self, until_ns: int) -> None:
        while not self._slice(until_ns):
            await asyncio.sleep(0)
            await self._recorders.until_room()

    def _slice(self, until_ns: int | None) -> bool:
        """Work for one slice of real time, and return whether `until_ns` is reached.

        A slice ends early if a reader of a recording has enough to read, so that nothing is lost at full speed.
        """
        rig, give_up_s = self._rig, time.monotonic() + SLICE_S
        while (next_ns := rig.next_ns()) is not None and (until_ns is None or next_ns <= until_ns):
            rig.step()
            if time.monotonic() > give_up_s or self._recorders.is_behind:
                return False
        if until_ns is not None:
            rig.run_until(until_ns)
        return True

    def _rebase(self) -> None:
        self._base_s, self._base_ns = self._loop.time(), self._rig.now_ns

    def _listen(self, bus: str, on_delivery: OnDelivery) -> Callable[[], None]:
        """Call `on_delivery` with the messages of a bus; without listeners, the rig keeps its shortcuts."""
        self._listeners[bus] = on_delivery
        if self._end_listening is None:
            self._end_listening = self._rig.on_delivery(self._on_delivery)

        def end() -> None:
            del self._listeners[bus]
            if not self._listeners and self._end_listening is not None:
                self._end_listening()
                self._end_listening = None

        return end

    def _on_delivery(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        listener = self._listeners.get(bus.name)
        if listener is not None:
            listener(delivery)

    def _status(self) -> dict[str, Any]:
        return {
            **rig_status(self._config, self._control, self._started_s, lambda _device: self._config.name),
            "run": None,
            "state": "ready" if self._may_run.is_set() else "paused",
            "now_ns": self._rig.now_ns,
            "speed": self._speed,
            "processes": {self._config.name: self._own_process()},
            **self.beside(),
        }

    def _own_process(self) -> dict[str, Any]:
        """Return the facts of the only process, in the words that processes have in real time."""
        return {
            "state": ProcessState.READY,
            "pid": os.getpid(),
            "uptime_s": round(time.monotonic() - self._started_s, 3),
            "restarts": 0,
            "step": "",
            "on_exit": "stop",
            "buses": list(self._config.buses),
            "devices": list(self._config.devices),
        }

    async def _brief(self, _verb: str, _message: Any) -> dict[str, Any]:
        return {**brief_facts(), "state": ProcessState.READY}

    async def _process_status(self, _verb: str, _message: Any) -> dict[str, Any]:
        return {
            **facts(),
            "state": "ready",
            "buses": {name: self._rig.statistics(name) for name in self._rig.buses},
        }
