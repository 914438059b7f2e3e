"""The work of `fieldrig up` while a rig runs: signals, the trace, and messages for the user."""

import asyncio
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from fieldrig.cli.coverage import QUESTION
from fieldrig.cli.display import Display
from fieldrig.cli.reach import help_of
from fieldrig.config.near_names import near_names
from fieldrig.config.rig_file import RigConfig
from fieldrig.config.source import gather
from fieldrig.control import endpoint
from fieldrig.control.messages import Control
from fieldrig.coverage import collecting
from fieldrig.coverage.data import written
from fieldrig.coverage.summary import Coverage
from fieldrig.errors import ControlError
from fieldrig.outside.shared_token import token
from fieldrig.real.children import Children
from fieldrig.real.core_advice import advice
from fieldrig.real.host import loop_factory
from fieldrig.real.page_process import NAME, PageProcess, page_of
from fieldrig.real.placement import placement, sockets
from fieldrig.real.started_outside import AttendedRig
from fieldrig.real.supervisor import Supervisor
from fieldrig.real.this_system import check_system
from fieldrig.system.descriptors import ensure_for
from fieldrig.system.exits import Exit
from fieldrig.system.ready_file import ALL, ready_file
from fieldrig.system.run_folder import RunFolder
from fieldrig.system.this_process import age_s, interrupt_on_signals, on_signals, usable_cores
from fieldrig.text.nearest import closest
from fieldrig.traces.recorder import Recorder
from fieldrig.virtual.keeper import KeptRig, keep, why_no_way_back
from fieldrig.virtual.prelude import Prelude
from fieldrig.virtual.service import VirtualService

ENDING = ("SIGINT", "SIGTERM", "SIGHUP")


class Service(Protocol):
    beside: Callable[[], Mapping[str, Any]]

    async def run(self) -> Exit: ...

    def end(self) -> None: ...


@dataclass(frozen=True, slots=True)
class UpOptions:
    """The options of `fieldrig up`."""

    overrides: Sequence[str] = ()
    trace: Path | None = None
    is_attended: bool = False
    is_realtime: bool = False
    is_quiet: bool = False
    has_page: bool = True


def run_rig(config: RigConfig, options: UpOptions, prelude: Prelude | None = None) -> Exit:
    """Run the rig to its end; a `prelude` is for one in virtual time.  RigError if it cannot start."""
    token()  # one that is wrong is found before anything starts
    display = Display(config, time.monotonic() - age_s(), options.is_quiet)
    for doubt in near_names(gather(config.path, options.overrides), config.buses, config.devices):
        display.warn(str(doubt))
    if options.is_attended or config.time == "virtual":
        endpoint.check_free(config.control)
        with _page(config, options, None) as page, _keeper(config, options) as keeper:
            return _in_loop(config, options, display, page, _maker(config, options, display, keeper, prelude))
    return _run_processes(config, options, display)


@contextmanager
def _keeper(config: RigConfig, options: UpOptions) -> Iterator[KeptRig | None]:
    """Keep a rig that can go back in time in a process of its own; None for any other."""
    if options.is_attended or why_no_way_back(config):
        yield None
        return
    with keep(config) as kept:
        yield kept


def _maker(
    config: RigConfig, options: UpOptions, display: Display, keeper: KeptRig | None, prelude: Prelude | None
) -> Callable[[Control], Service]:
    """Return what makes the service of a rig without processes of its own."""
    if not options.is_attended:
        return lambda control: VirtualService(config, control, display.report, keeper, prelude)
    plans = placement(config)
    return lambda control: AttendedRig(config, plans, control, display.report)


def _page(config: RigConfig, options: UpOptions, log: Path | None) -> AbstractContextManager[PageProcess | None]:
    return page_of(config, log, options.overrides) if options.has_page else nullcontext()


def _run_processes(config: RigConfig, options: UpOptions, display: Display) -> Exit:
    """Check everything that may refuse the start, then start the processes."""
    check_system()
    interrupt_on_signals(ENDING)
    plans = placement(config)
    ensure_for(len(plans))
    endpoint.check_free(config.control)
    folder = RunFolder(config.run)
    folder.claim(sockets(config))
    for warning in advice(config, usable_cores()):
        display.warn(warning)
    try:
        folder.wait_for_the_last()
        children = Children(config, plans, folder, overrides=options.overrides, is_realtime=options.is_realtime)
        try:
            children.fork()
            with _page(config, options, folder.folder / f"log/_{NAME}.log") as page:
                return _in_loop(
                    config,
                    options,
                    display,
                    page,
                    lambda control: Supervisor(config, plans, control, children, display.report),
                )
        finally:
            children.close()
    finally:
        folder.release()


def _in_loop(
    config: RigConfig,
    options: UpOptions,
    display: Display,
    page: PageProcess | None,
    make: Callable[[Control], Service],
) -> Exit:
    with asyncio.Runner(loop_factory=loop_factory()) as runner:
        return runner.run(_run(config, options, display, page, make))


async def _run(
    config: RigConfig,
    options: UpOptions,
    display: Display,
    page: PageProcess | None,
    make: Callable[[Control], Service],
) -> Exit:
    control = Control(endpoint.listen(config.control), config.name)
    try:
        service = make(control)
        control.serve("help/*", partial(_help, config))
        control.serve(QUESTION, _coverage)
        control.listen_to("notice/*", display.notice)
        _end_on_signals(service, display)
        recorder = Recorder(options.trace) if options.trace is not None else None
        if recorder is not None:
            control.listen_to("trace/*", recorder.take)
        tending = None
        if page is not None:
            service.beside = page.status
            tending = asyncio.get_running_loop().create_task(page.tend(display.report))
        watching = asyncio.get_running_loop().create_task(display.watch_load(control))
        running = asyncio.get_running_loop().create_task(_serve(service, config))
        try:
            await asyncio.sleep(0)  # the rig is at work while this is printed
            processes = 0 if config.time == "virtual" else len(placement(config))
            display.introduce(processes, {} if page is None else page.addresses)
            return await running
        finally:
            watching.cancel()
            if page is not None and tending is not None:
                tending.cancel()
                await asyncio.wait({tending})
                await page.end()
            if recorder is not None:
                display.note(recorder.close())
    finally:
        await control.close()


async def _help(config: RigConfig, name: str, _message: Any) -> dict[str, Any]:
    if name not in config.buses and name not in config.devices:
        raise ControlError(
            f"{config.name} has no bus or device {name!r}", closest(name, [*config.buses, *config.devices])
        )
    return help_of(config, name)


async def _coverage(_verb: str, _message: Any) -> str:
    """Answer `fieldrig coverage`.  ControlError if the programs of the rig have no marks."""
    if not collecting.is_on():
        raise ControlError("the programs of this rig have no marks", "expected a rig that was started with --coverage")
    return written(Coverage(collecting.news())).decode()


async def _serve(service: Service, config: RigConfig) -> Exit:
    """Run the service; beside it the file for health checks, if it has processes and so a run folder."""
    if not isinstance(service, AttendedRig | Supervisor):
        return await service.run()
    with ready_file(config.run, ALL, lambda: service.roster.is_ready):
        return await service.run()


def _end_on_signals(service: Service, display: Display) -> None:
    def end() -> None:
        display.on_signal()
        service.end()

    on_signals(ENDING, end)
