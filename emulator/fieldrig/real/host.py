"""One process of a rig in real time: `python -m fieldrig.real.host FILE --process NAME`.

The rig's supervisor starts it, holds its standard input open, follows its steps and reads its log.  The process opens
its hubs, asks the rig to join, attaches and starts its devices, reports that it is ready, and answers questions.  It
ends on SIGTERM, or when its standard input ends because the supervisor is gone.  An exception in a device's code ends
it with exit code 70.
"""

import argparse
import asyncio
import contextlib
import gc
import logging
import os
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from fieldrig.clock import S
from fieldrig.config.rig_file import RigConfig, load
from fieldrig.control import endpoint
from fieldrig.control.device_questions import RealPoints, answers
from fieldrig.control.messages import Control, NoAnswerError
from fieldrig.control.notices import Watched, look_on
from fieldrig.control.question_words import asked
from fieldrig.coverage import collecting
from fieldrig.errors import ConfigError, ControlError, RigError
from fieldrig.hub.bus_stream import BusStream
from fieldrig.loop.real_clock import RealClock
from fieldrig.loop.threaded_loop import ThreadedLoop
from fieldrig.outside.untrusted import field
from fieldrig.real.placement import ProcessPlan, linked_buses
from fieldrig.real.process import DeviceProcess
from fieldrig.real.progress import READY, finish, step
from fieldrig.real.recorded import ProcessSource
from fieldrig.recording.record_set import RecordSet
from fieldrig.recording.recorders import Recorders
from fieldrig.system import log_files
from fieldrig.system.exits import Exit
from fieldrig.system.host_lateness import WINDOW_NS, LateHost, Lateness, LateRecords
from fieldrig.system.ready_file import ready_file
from fieldrig.system.run_folder import join_run
from fieldrig.system.this_process import brief_facts, facts, on_signals

log = logging.getLogger(__name__)

GRACE_S = 2.0
"""Time between the request to end and the forced end."""
RETRY_S = 0.02
MOST_OTHERS = 3
"""Most other processes whose lateness is named beside a trouble of a device."""
LIFELINE = 0
"""File descriptor of the standard input, a pipe that the supervisor holds open."""
WAITING_S = 3600.0
"""Time limit of a supervised process; in practice its supervisor gives up first."""
REALTIME_PRIORITY = 10
COLLECTION = (10_000, 20, 50)
"""Thresholds of the search for circular garbage.  By Python's own ones it looks through a large program several times
while a controller takes it over, and so costs cycles of a ring."""


class Host:
    def __init__(self, config: RigConfig, plan: ProcessPlan, patience_s: float) -> None:
        self._config, self._plan, self._patience_s = config, plan, patience_s
        self._ended: asyncio.Future[Exit] = asyncio.get_running_loop().create_future()
        self._streams: list[BusStream] = []
        self._state = "starting"
        self._late = LateHost(Lateness(), dict)
        self._late_others: dict[str, str] = {}
        """The other processes of the rig for which the host is late, with the words for it."""
        self._points: dict[str, RealPoints] = {}
        self._recorders: Recorders | None = None
        self._window: asyncio.TimerHandle | None = None
        self._looking: asyncio.Task[None] | None = None

    async def run(self) -> Exit:
        """Run the process to its end.  RigError if it cannot start."""
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(self._on_exception)
        clock = RealClock(loop)
        step("connecting to the rig")
        control = Control(await endpoint.connect_patiently(self._config.control, self._patience_s), self._config.name)
        step("connected to the rig")
        process = DeviceProcess(self._config, self._plan, clock, control)
        control.keep(process.pace)
        try:
            with ready_file(self._config.run, self._plan.name, lambda: self._state == "ready"):
                if not await self._unless_ended(self._start(control, process)):
                    return self._ended.result()
                return await self._ended
        finally:
            if self._window is not None:
                self._window.cancel()
            if self._looking is not None:
                self._looking.cancel()
            if self._recorders is not None:
                self._recorders.close()
            collecting.flush()
            await process.close()
            for stream in self._streams:
                stream.flush()
            await control.close()
            clock.close()

    def end(self, code: Exit = Exit.OK) -> None:
        if not self._ended.done():
            self._ended.set_result(code)

    async def _unless_ended(self, work: Coroutine[Any, Any, None]) -> bool:
        """Return whether `work` finished before this process was asked to end."""
        task = asyncio.get_running_loop().create_task(work)
        both: set[asyncio.Future[Any]] = {task, self._ended}
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        if task.done():
            task.result()
            return True
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task
        return False

    async def _start(self, control: Control, process: DeviceProcess) -> None:
        name = self._plan.name
        await process.open()
        control.show_life(f"alive/{name}")
        control.serve(f"process/{name}/status", lambda _verb, _message: self._status(process, control))
        control.serve(f"process/{name}/brief", self._brief)
        control.serve(f"process/{name}/restart", partial(self._restart, process))
        for bus in process.traced_buses:  # before others may send
            self._streams.append(BusStream(control, bus, name, partial(process.listen, bus.name)))
        step("joining the rig")
        terms = await self._join(control)
        step("joined the rig")
        for stream in self._streams:
            stream.begin(field(terms, "epoch_ns", int))
        await process.attach(self._patience_s)
        process.start()
        source = ProcessSource(process)
        make = partial(RecordSet, source, is_lossless=False)
        self._recorders = Recorders(control, name, source, make, epoch_ns=field(terms, "epoch_ns", int))
        watched = [*process.watched]
        for device_name, device in process.devices.items():
            points = RealPoints(device_name, device, process.clock, partial(self._host_words, process.clock.host))
            self._points[device_name] = points
            control.serve(f"device/{device_name}/*", answers(points))
            watched.append(Watched(device_name, points.faults))
        if self._points:
            control.listen_to("late/*", self._on_late)
        looking = look_on(control, watched, process.clock.now_ns, self._troubles)
        self._looking = asyncio.get_running_loop().create_task(looking)
        gc.collect()
        gc.freeze()  # what is there now stays: later collections needn't look at it
        gc.set_threshold(*COLLECTION)
        self._watch_lateness(process)
        self._keep_coverage()
        self._state = "ready"
        step(READY)
        finish()
        control.publish(f"ready/{name}", {"pid": os.getpid()})
        log.info("ready: %s", ", ".join((*self._plan.buses, *self._plan.devices)))

    def _keep_coverage(self) -> None:
        """Note now and then what the programs have run, as this process may be killed."""
        if collecting.is_on():
            collecting.flush()
            asyncio.get_running_loop().call_later(collecting.FLUSH_S, self._keep_coverage)

    def _watch_lateness(self, process: DeviceProcess) -> None:
        """Judge from now on, window by window, whether the host is late; its start is slow on any host."""
        lateness = process.clock.host
        lateness.turn()
        for handler in logging.getLogger().handlers:
            handler.addFilter(LateRecords(lateness))
        self._late = LateHost(lateness, lambda: {name: bus.statistics() for name, bus in process.served.items()})
        loop = asyncio.get_running_loop()

        def turn(due_s: float) -> None:
            lateness.note(round(max(loop.time() - due_s, 0.0) * S))  # a process without timers learns it here
            words = self._late.turn()
            if words is not None:
                log.warning("the host is %s", f"late: {words}" if words else "on time again")
                process.control.publish(f"late/{self._plan.name}", {"words": words})
            begin()

        def begin() -> None:
            due_s = loop.time() + WINDOW_NS / S
            self._window = loop.call_at(due_s, turn, due_s)

        begin()

    def _on_late(self, name: str, message: Any) -> None:
        match message:
            case {"words": ""}:
                self._late_others.pop(name, None)
            case {"words": str(words)} if name != self._plan.name and len(self._late_others) < MOST_OTHERS:
                self._late_others[name] = words

    def _host_words(self, lateness: Lateness) -> str:
        """Return how late the host was for this process in the last seconds, or else for which others it is late."""
        others = [f"the host was late for {name}: {words}" for name, words in self._late_others.items()]
        return lateness.words() or "; ".join(others)

    def _troubles(self) -> dict[str, str]:
        """Return the words about the host beside each trouble of a device, by DEVICE/KEY."""
        looks = ((device, points.look()) for device, points in self._points.items())
        return {f"{device}/{key}": words for device, look in looks for key, words in look.items()}

    async def _join(self, control: Control) -> dict[str, Any]:
        """Ask until there is an answer, as the rig's session opens slightly before the service that answers in it."""
        loop = asyncio.get_running_loop()
        give_up_s = loop.time() + self._patience_s
        while True:
            left_s = max(give_up_s - loop.time(), RETRY_S)  # a busy host may have slept past the end
            try:
                terms: dict[str, Any] = await control.ask(
                    "rig/join", {"process": self._plan.name, "pid": os.getpid()}, left_s
                )
            except NoAnswerError:
                if loop.time() + RETRY_S > give_up_s:
                    raise
                await asyncio.sleep(RETRY_S)
            else:
                return terms

    async def _brief(self, _verb: str, _message: Any) -> dict[str, Any]:
        return {**brief_facts(), "state": self._state, "late": self._late.facts()}

    async def _restart(self, process: DeviceProcess, verb: str, message: Any) -> dict[str, Any]:
        match message:
            case {"device": str(name)} if name in process.devices:
                process.clock.handle(process.devices[name].restart)
                log.info("%s was switched off and on", name)
                return {}
        raise ControlError(f"{self._plan.name} cannot {asked(verb, message)}", f"it has: {', '.join(process.devices)}")

    async def _status(self, process: DeviceProcess, control: Control) -> dict[str, Any]:
        return {
            **facts(),
            "state": self._state,
            "timers": process.clock.lateness(),
            "late": self._late.facts(),
            "troubles": self._troubles(),
            "buses": {name: subject.statistics() for name, subject in process.served.items()},
            "limits": control.limits(),
            "client_limits": {name: dict(device.limits_reached()) for name, device in process.devices.items()},
            "stores": {name: trouble for name, store in process.stores.items() if (trouble := store.trouble())},
        }

    def _on_exception(self, _loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Log an OSError, which the network or a peer has caused; end the process for a fault of the code in it."""
        cause = context.get("exception")
        if cause is None or isinstance(cause, OSError):
            log.warning("%s: %s", context.get("message"), cause)
            return
        log.critical("%s", context.get("message"), exc_info=cause)
        self.end(Exit.CRASHED)


def run_process(config: RigConfig, plan: ProcessPlan, *, is_supervised: bool, is_realtime: bool = False) -> Exit:
    """Run one process of the rig until it is asked to end."""
    step("rig file read")
    hold = join_run(config.run)
    name_process(plan.name)
    buses = [config.buses[bus].bus for device in plan.devices for bus in linked_buses(config.devices[device])]
    for name, value in (item for bus in buses for item in bus.environment.items()):
        os.environ.setdefault(name, value)
    # Threads that are made later have the same scheduling.
    if is_realtime or any(bus.realtime for bus in buses):
        _ask_for_realtime()
    try:
        new_loop = ThreadedLoop if any(bus.has_threads for bus in buses) else loop_factory()
        with asyncio.Runner(loop_factory=new_loop) as runner:
            return runner.run(_run(config, plan, is_supervised))
    except ConfigError as wrong:
        print(f"error: {wrong}", file=sys.stderr)  # noqa: T201  the supervisor shows it
        return Exit.WRONG
    except RigError as cause:
        print(f"error: {cause}", file=sys.stderr)  # noqa: T201  the supervisor shows it
        return Exit.CANNOT_START
    except Exception:
        log.exception("%s: a fault in its code", plan.name)
        return Exit.CRASHED
    finally:
        hold.close()


async def _run(config: RigConfig, plan: ProcessPlan, is_supervised: bool) -> Exit:
    loop = asyncio.get_running_loop()
    host = Host(config, plan, WAITING_S if is_supervised else config.start_timeout_s)
    on_signals(("SIGTERM", "SIGINT"), host.end)
    if is_supervised:
        end_with_parent(lambda: loop.call_soon_threadsafe(host.end))
    return await host.run()


def end_with_parent(end: Callable[[], object]) -> None:
    """End this process when the supervisor is gone.  This is a thread, so that it also ends a hung loop."""

    def watch() -> None:
        while os.read(LIFELINE, 1024):
            pass
        with contextlib.suppress(RuntimeError):  # the loop has ended by itself
            end()
        time.sleep(GRACE_S)
        os._exit(Exit.CRASHED)

    threading.Thread(target=watch, name="parent", daemon=True).start()


def loop_factory() -> Callable[[], asyncio.AbstractEventLoop] | None:
    try:
        import uvloop
    except ImportError:  # Windows
        return None
    return uvloop.new_event_loop


def name_process(name: str) -> None:
    """Set the name that `ps` and `top` show."""
    with contextlib.suppress(OSError):  # only Linux has it
        Path("/proc/self/comm").write_text(f"rig:{name}", encoding="utf-8")


def _ask_for_realtime() -> None:
    cause: Exception | str = "this system has none"
    if sys.platform == "linux":
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(REALTIME_PRIORITY))
        except (AttributeError, PermissionError) as fault:
            cause = fault
        else:
            return
    log.warning("SCHED_FIFO is not available (%s) and not used; it needs root or CAP_SYS_NICE", cause)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    parser = argparse.ArgumentParser(prog="python -m fieldrig.real.host", description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--process", required=True)
    parser.add_argument("--buses", default="", help="that it runs, with commas between")
    parser.add_argument("--devices", default="", help="that it runs, in order, with commas between")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--realtime", action="store_true")
    parser.add_argument("--log", type=Path, help="a file of bounded size for what it says")
    options = parser.parse_args(arguments)
    if options.log is not None:
        log_files.take_over(options.log)
    start_log()
    buses, devices = (tuple(filter(None, names.split(","))) for names in (options.buses, options.devices))
    plan = ProcessPlan(options.process, buses, devices, attaches=(), after=(), on_exit="restart")
    step("reading the rig file")
    try:
        config = load(options.file, options.set, only=(*buses, *devices))
    except ConfigError as wrong:
        print(f"error: {wrong}", file=sys.stderr)  # noqa: T201  the supervisor shows it
        sys.exit(Exit.WRONG)
    sys.exit(run_process(config, plan, is_supervised=True, is_realtime=options.realtime))


def start_log() -> None:
    level = os.environ.get("FIELDRIG_LOG", "INFO").upper()
    logging.basicConfig(format="%(asctime)s %(levelname)s %(name)s: %(message)s", level=level)


if __name__ == "__main__":
    main()
