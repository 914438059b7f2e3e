"""What `fieldrig up` does while a rig runs: signals, the trace, and words for the person who started it."""

import asyncio
import signal
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from fieldrig import endpoint
from fieldrig.attended import AttendedRig
from fieldrig.cli.display import Display
from fieldrig.config import RigConfig
from fieldrig.control import Control
from fieldrig.exits import Exit
from fieldrig.host import loop_factory
from fieldrig.hub_wire import socket_name
from fieldrig.placement import is_modelled, placement
from fieldrig.run_folder import RunFolder
from fieldrig.supervisor import Supervisor
from fieldrig.trace_files import Recorder
from fieldrig.virtual_service import VirtualService


class Service(Protocol):
    async def run(self) -> Exit: ...

    def end(self) -> None: ...


def run_rig(
    config: RigConfig,
    overrides: Sequence[str],
    trace: Path | None,
    *,
    is_attended: bool,
    is_realtime: bool,
    is_quiet: bool,
) -> Exit:
    """RigError if the rig can't start."""
    started_s = time.monotonic() - time.process_time()  # this process was at work before it came here
    display = Display(config, started_s, is_quiet)
    with asyncio.Runner(loop_factory=loop_factory()) as runner:
        if is_attended or config.time == "virtual":
            return runner.run(_run(config, overrides, trace, display, None, is_attended, is_realtime))
        folder = RunFolder(config.run)
        folder.claim([socket_name(entry.bus) for entry in config.buses.values() if is_modelled(entry)])
        try:
            folder.wait_for_the_last()
            return runner.run(_run(config, overrides, trace, display, folder, is_attended, is_realtime))
        finally:
            folder.release()


async def _run(
    config: RigConfig,
    overrides: Sequence[str],
    trace: Path | None,
    display: Display,
    folder: RunFolder | None,
    is_attended: bool,
    is_realtime: bool,
) -> Exit:
    control = Control(endpoint.listen(config.control), config.name)
    try:
        service: Service
        if config.time == "virtual":
            service = VirtualService(config, control, display.report)
        elif folder is None:
            service = AttendedRig(config, placement(config), control, display.report)
        else:
            service = Supervisor(
                config,
                placement(config),
                control,
                folder,
                display.report,
                overrides=overrides,
                is_realtime=is_realtime,
            )
        _on_signals(service, display)
        recorder = Recorder(trace) if trace is not None else None
        if recorder is not None:
            control.listen_to("trace/*", recorder.take)
        display.introduce(0 if config.time == "virtual" else len(placement(config)))
        watching = asyncio.get_running_loop().create_task(display.watch_load(control))
        try:
            return await service.run()
        finally:
            watching.cancel()
            if recorder is not None:
                display.note(recorder.close())
    finally:
        await control.close()


def _on_signals(service: Service, display: Display) -> None:
    loop = asyncio.get_running_loop()

    def end() -> None:
        display.on_signal()
        service.end()

    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            loop.add_signal_handler(getattr(signal, name), end)
