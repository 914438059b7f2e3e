"""A rig in virtual time under `fieldrig up`: paced, paused, stepped, taken back, and controlled by messages.

The rig runs in slices of `SLICE_S`, so that it answers questions even at full speed.  Where there is fork, it is in a
process of its own, the keeper.
"""

import asyncio
import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

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
from fieldrig.outside.untrusted import MalformedError, field, shown
from fieldrig.real.roster import ProcessState, Report
from fieldrig.recording.recorders import Recorders
from fieldrig.system.exits import Exit
from fieldrig.virtual.journey import Journey, Search
from fieldrig.virtual.keeper import NO_KEEPER, KeptRig, why_no_way_back
from fieldrig.virtual.prelude import QUESTION, Prelude
from fieldrig.virtual.readings import seconds
from fieldrig.virtual.remote_sets import RemoteSets
from fieldrig.virtual.served import News, Played, ServedRig

SLICE_S = 0.01
"""Length of a slice in real time."""
FASTEST = 1e9
"""Largest speed in times of real time; faster than any host."""
BEHIND_S = 0.5
"""Largest lag; a rig that lags further gives up the lost time."""


def _settle(future: "asyncio.Future[None]") -> None:
    if not future.done():
        future.set_result(None)


class _Part:
    """A bus or a device of the rig."""

    def __init__(self, journey: Journey, name: str) -> None:
        self._journey, self._name = journey, name

    @property
    def _rig(self) -> KeptRig | ServedRig:
        """The rig at present."""
        return self._journey.rig

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        return self._journey.add_fault(self._name, fault)

    def clear_fault(self, number: int) -> None:
        self._journey.clear_fault(self._name, number)

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
        self._journey.set(self._name, key, value)

    def answer(self, question: str, message: Any) -> Any:
        return self._journey.answer(self._name, question, message)


class VirtualBus(_Part):
    def statistics(self) -> dict[str, float]:
        return self._rig.statistics(self._name)

    def conditions(self) -> Mapping[str, str]:
        return self._rig.conditions(self._name)

    def signals(self) -> Mapping[str, Mapping[str, Any]]:
        return self._rig.signals(self._name)


class VirtualService:
    def __init__(
        self,
        config: RigConfig,
        control: Control,
        report: Report,
        keeper: KeptRig | None = None,
        prelude: Prelude | None = None,
    ) -> None:
        """`keeper` has the rig; without one it is built here, and cannot go back in time.

        After a `prelude` the rig is paused.
        """
        self.beside: Callable[[], Mapping[str, Any]] = dict
        """Returns what `status` also shows: what runs beside the rig."""
        self._config, self._control, self._report, self._keeper = config, control, report, keeper
        self._prelude = prelude
        self._loop = asyncio.get_running_loop()
        self._ended: asyncio.Future[Exit] = self._loop.create_future()
        self._may_run = asyncio.Event()
        self._may_run.set()
        self._listeners: dict[str, OnDelivery] = {}
        self._speed = config.speed
        self._started_s = time.monotonic()
        self._base_s = self._loop.time()  # virtual time is paced from here: the host's time, and ours at that time
        self._base_ns = 0
        self._standing = asyncio.Lock()
        """Held while the past is looked at, and the rig stands still."""
        self._steps, self._interruptions = 0, 0
        """Steps that run or wait for their turn, and how often such steps were ended."""

    async def run(self) -> Exit:
        """Run until `end` is called.  RigError if a device cannot be built, or devices answer each other endlessly."""
        self._journey = await self._begin()
        try:
            self._serve()
            await asyncio.sleep(0)  # what can be reached is printed meanwhile, before it is ready
            if self._prelude is not None:
                self._may_run.clear()
                await self._prelude.play(self._journey, self._run_until)
            self._rebase()
            self.publish("ready")
            pacer = self._loop.create_task(self._pace())
            looking = self._loop.create_task(look_on(self._control, self._watched, lambda: self._journey.now_ns))
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
        finally:
            self._journey.close()
        return self._ended.result()

    async def _begin(self) -> Journey:
        """Return the rig when it is built."""
        keeper = self._keeper
        if keeper is None:
            return Journey(ServedRig(self._config), why_no_way_back(self._config) or NO_KEEPER)
        built: asyncio.Future[None] = self._loop.create_future()
        self._loop.add_reader(keeper.fileno(), _settle, built)
        try:
            await built
        finally:
            self._loop.remove_reader(keeper.fileno())
            keeper.block()  # uvloop has changed it
        keeper.wait_until_built()
        return Journey(keeper, why_no_way_back(self._config))

    def end(self) -> None:
        self._interruptions += 1
        if not self._ended.done():
            self._ended.set_result(Exit.OK)

    def publish(self, what: str, text: str = "") -> None:
        happened = event(what, "", text)
        self._report(happened)
        self._control.publish("event", happened._asdict())

    def _serve(self) -> None:
        control, journey = self._control, self._journey
        self._streams = [
            BusStream(control, entry.bus, self._config.name, partial(self._listen, name))
            for name, entry in self._config.buses.items()
        ]
        self._watched: list[Watched] = []
        for bus in self._config.buses:
            subject = VirtualBus(journey, bus)
            control.serve(f"bus/{bus}/*", answers_of_bus(subject))
            self._watched.append(Watched(bus, subject.faults, subject.conditions))
        for device in self._config.devices:
            points = VirtualPoints(journey, device)
            control.serve(f"device/{device}/*", answers(points))
            self._watched.append(Watched(device, points.faults))
        self._sets = RemoteSets(journey, self._take)
        self._recorders = Recorders(control, self._config.name, self._sets, self._sets.begin, is_lossless=True)
        control.serve(f"process/{self._config.name}/status", self._process_status)
        control.serve(f"process/{self._config.name}/brief", self._brief)
        control.serve("rig/*", self._answer)
        if self._prelude is not None:
            control.serve(f"{QUESTION}/*", self._prelude.answer)

    async def _answer(self, verb: str, message: Any) -> Any:
        match verb, message:
            case "status", _:
                return self._status()
            case "stop", _:
                self.end()
            case "pause", _:
                self._stand()
            case "run", {"speed": int() | float() | None as speed} if speed is None or 0 < speed <= FASTEST:
                self._speed = speed
                self._go_on()
            case "run", None:
                self._go_on()
            case "step", {"ns": int(duration_ns)} if 0 <= duration_ns < NEVER_NS - self._journey.now_ns:
                await self._step(duration_ns)
            case "back", {"ns": int(instant_ns)} if instant_ns >= 0:
                self._stand()
                async with self._standing:
                    self._journey.back(instant_ns)
                    self._go_on_from_the_past()
            case "last" | "back", {"search": search}:
                return await self._search(search, is_to_go=verb == "back")
            case "restart", {"name": str(name)}:
                self._journey.restart(name)
            case _:
                remedy = "it can: status, stop, pause, run, step, back, last, restart"
                raise ControlError(f"this rig cannot {asked(verb, message)}", remedy)
        return self._where()

    def _stand(self) -> None:
        """Stand still; a step ends where it is."""
        self._may_run.clear()
        self._interruptions += 1

    def _go_on(self) -> None:
        """Run from now on; a step ends where it is."""
        self._rebase()
        self._may_run.set()
        self._interruptions += 1

    async def _step(self, duration_ns: int) -> None:
        """Run for a duration, or until the rig is paused, let run, taken back or stopped."""
        until_ns, before = self._journey.now_ns + duration_ns, self._interruptions
        self._may_run.clear()
        self._steps += 1
        try:
            await self._run_until(until_ns, lambda: self._interruptions == before)
        finally:
            self._steps -= 1

    def _where(self) -> dict[str, Any]:
        return {"now_ns": self._journey.now_ns, "is_paused": self._is_paused()}

    def _is_paused(self) -> bool:
        return not self._may_run.is_set() and self._steps == 0

    async def _search(self, message: Any, *, is_to_go: bool) -> dict[str, Any]:
        """Answer what a device has found in the past, and go there if that is wanted."""
        search = Search(
            field(message, "device", str),
            field(message, "question", str),
            field(message, "begin", dict),
            field(message, "look", dict),
        )
        before_ns = message.get("before_ns")
        if before_ns is not None and type(before_ns) is not int:
            raise MalformedError(f"before_ns: expected an instant in nanoseconds, found {shown(before_ns)}")
        find = self._journey.go_to if is_to_go else self._journey.find
        async with self._standing:
            backs = self._journey.backs
            found = await find(search, before_ns)
            if self._journey.backs > backs:
                self._may_run.clear()
                self._go_on_from_the_past()
        return {"found": found, **self._where()}

    def _go_on_from_the_past(self) -> None:
        """Have everybody outside take note that what came after this instant has never been."""
        journey = self._journey
        self._recorders.forget()
        for stream in self._streams:
            stream.go_back(journey.backs, journey.now_ns)
        journey.rig.hear(self._listeners)
        self._rebase()
        self.publish("back", f"to {seconds(journey.now_ns)}")

    async def _pace(self) -> None:
        while True:
            if not self._may_run.is_set():
                await self._may_run.wait()
                self._rebase()
            await self._recorders.until_room()
            async with self._standing:
                is_waiting = self._may_run.is_set() and self._paced()
            await asyncio.sleep(SLICE_S if is_waiting else 0)

    def _paced(self) -> bool:
        """Run a slice, and return true if nothing is left to do for a while."""
        if self._speed is None:
            # At full speed; a rig in which nothing ever happens stands still.
            return self._play(None).next_ns is None
        elapsed_s = self._loop.time() - self._base_s
        target_ns = self._base_ns + round(elapsed_s * self._speed * S)
        if self._play(target_ns).is_reached:
            return True
        if target_ns - self._journey.now_ns > BEHIND_S * self._speed * S:
            self._rebase()
        return False

    async def _run_until(self, until_ns: int, may_go_on: Callable[[], bool] = lambda: True) -> None:
        async with self._standing:
            while may_go_on() and not self._play(until_ns).is_reached:
                await asyncio.sleep(0)
                await self._recorders.until_room()

    def _play(self, until_ns: int | None) -> Played:
        played = self._journey.play(until_ns, SLICE_S)
        self._take(played.news)
        return played

    def _take(self, news: News) -> None:
        """Give listeners and readers what is theirs."""
        for bus, delivery in news.heard:
            listener = self._listeners.get(bus)
            if listener is not None:
                listener(delivery)
        for name, data in news.batches:
            self._sets.publish(name, data)
        self._sets.is_behind = news.is_behind

    def _rebase(self) -> None:
        self._base_s, self._base_ns = self._loop.time(), self._journey.now_ns

    def _listen(self, bus: str, on_delivery: OnDelivery) -> Callable[[], None]:
        """Call `on_delivery` with the messages of a bus."""
        self._listeners[bus] = on_delivery
        self._journey.rig.hear(self._listeners)

        def end() -> None:
            del self._listeners[bus]
            self._journey.rig.hear(self._listeners)

        return end

    def _status(self) -> dict[str, Any]:
        return {
            **rig_status(self._config, self._control, self._started_s, lambda _device: self._config.name),
            "run": None,
            "state": "paused" if self._is_paused() else "ready",
            "now_ns": self._journey.now_ns,
            "first_ns": self._journey.first_ns,
            "speed": self._speed,
            **({} if self._prelude is None else {"prelude": self._prelude.name}),
            "processes": {self._config.name: self._own_process()},
            **self.beside(),
        }

    def _own_process(self) -> dict[str, Any]:
        """Return the facts of the only process, in the words that processes have in real time."""
        return {
            "state": ProcessState.READY,
            "pid": self._journey.rig.pid,
            "uptime_s": round(time.monotonic() - self._started_s, 3),
            "restarts": 0,
            "step": "",
            "on_exit": "stop",
            "buses": list(self._config.buses),
            "devices": list(self._config.devices),
        }

    async def _brief(self, _verb: str, _message: Any) -> dict[str, Any]:
        return {**self._journey.rig.process_facts(is_brief=True), "state": ProcessState.READY}

    async def _process_status(self, _verb: str, _message: Any) -> dict[str, Any]:
        rig = self._journey.rig
        return {
            **rig.process_facts(is_brief=False),
            "state": "ready",
            "buses": {name: rig.statistics(name) for name in self._config.buses},
        }
