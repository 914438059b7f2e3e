"""The output of `fieldrig up`: how to reach each part, what happens, and on a terminal one line with the load."""

import asyncio
import os
import shutil
import sys
import time
from collections.abc import Iterator, Mapping
from errno import EPIPE
from pathlib import Path
from typing import Any, NamedTuple, TextIO

from fieldrig.config import DeviceEntry, RigConfig
from fieldrig.control import Control
from fieldrig.device import RUN, Tool
from fieldrig.net import DEFAULT_ENDPOINT
from fieldrig.roster import Event
from fieldrig.steady_output import steady

REFRESH_S = 1.0
ERASE_LINE = "\r\x1b[K"
BOLD, DIM, RED, GREEN, YELLOW, PLAIN = "\x1b[1m", "\x1b[2m", "\x1b[31m", "\x1b[32m", "\x1b[33m", "\x1b[0m"
COLOURS = {"failed": RED, "died": YELLOW, "gone": YELLOW, "late": YELLOW, "warning": YELLOW, "ready": GREEN}
COUNTERS = ("frames", "requests", "messages", "characters")
"""The statistics of buses that are shown as a rate."""
TALKING = ("status", "watch", "get", "set", "fault")
"""The commands that connect to the control endpoint."""


class Part(NamedTuple):
    """A bus or device, and the lines that reach it."""

    name: str
    kind: str
    tools: list[Tool]


def parts(config: RigConfig) -> Iterator[Part]:
    """Yield the parts in the order of the rig file."""
    for name, bus in config.buses.items():
        yield Part(name, bus.kind, bus.bus.tools(config.run))
    for name, device in config.devices.items():
        tools = device.cls.tools(name, device.settings, _linked(config, device))
        yield Part(name, device.kind, [Tool(label, line.replace(RUN, str(config.run))) for label, line in tools])


def _linked(config: RigConfig, device: DeviceEntry) -> Mapping[str, Any]:
    return {
        parameter: [config.buses[bus].bus for bus in buses] if parameter in device.many else config.buses[buses[0]].bus
        for parameter, buses in device.links.items()
        if buses
    }


class Display:
    def __init__(self, config: RigConfig, started_s: float, is_quiet: bool) -> None:
        """`started_s` is the time of the monotonic clock when the command was entered."""
        self._config, self._started_s, self._is_quiet = config, started_s, is_quiet
        self._is_terminal = sys.stdout.isatty()
        self._err = steady(sys.stderr)
        self._out = steady(sys.stdout, self._on_lost_output)
        self._waiting = set[str]()
        self._was_ready = False
        self._has_load_line = False
        self._counted: dict[str, tuple[float, float]] = {}
        self._signals = 0

    def introduce(self, processes: int) -> None:
        config = self._config
        with_processes = f", {processes} processes" if processes else ""
        self._say(
            f"{self._styled(config.name, BOLD)}: time: {config.time}{with_processes}, control at {config.control}\n"
        )
        every = list(parts(config))
        width = max((len(part.name) for part in every), default=0)
        kind_width = max((len(part.kind) for part in every), default=0)
        for part in every:
            self._say(f"  {self._styled(part.name.ljust(width), BOLD)}  {part.kind.ljust(kind_width)}".rstrip())
            label_width = max((len(tool.label) for tool in part.tools), default=0)
            for tool in part.tools:
                label = self._styled(tool.label.ljust(label_width), DIM)
                self._say(f"      {label}  {_as_typed(tool.line, config.control)}")
        self._say("")

    def report(self, event: Event) -> None:
        """Print an event.

        Before the rig is ready only failures and warnings are printed; later all events, and if quiet deaths, restarts
        and warnings.
        """
        what, process = event.what, event.process
        if what == "ready" and not process:
            self._on_all_ready(event.text)
        elif what == "failed":
            self._fail(event)
        elif what == "stopping":
            self._say("stopping")
        elif what == "warning" or (self._was_ready and what not in ("stopped", "ready")):
            text = event.text.replace("\n", "\n    ")
            self._warn(f"{_clock(event.time_s)}  {self._styled(f'{process} {what}', COLOURS.get(what, ''))}: {text}")
        elif self._was_ready and what == "ready":
            self._warn(f"{_clock(event.time_s)}  {self._styled(f'{process} is back', GREEN)}")

    def on_signal(self) -> None:
        self._signals += 1
        if self._signals == 2:
            self._say("ending everything at once")

    def note(self, text: str) -> None:
        self._say(text)

    async def watch_load(self, control: Control) -> None:
        """Show the load of the buses in one line, in place, until cancelled."""
        if self._is_quiet or not self._is_terminal:
            return
        while True:
            await asyncio.sleep(REFRESH_S)
            if self._was_ready and not self._signals:
                self._show_load(await control.ask_all("bus/*/status", REFRESH_S))

    def _show_load(self, found: Mapping[str, Mapping[str, float]]) -> None:
        words = [self._load(bus, found[bus]) for bus in self._config.buses if bus in found]
        line = "   ".join(filter(None, words))[: shutil.get_terminal_size().columns - 1]
        self._out.write(f"{ERASE_LINE}{DIM}{line}{PLAIN}")
        self._out.flush()
        self._has_load_line = True

    def _load(self, bus: str, statistics: Mapping[str, float]) -> str:
        name = next((name for name in COUNTERS if name in statistics), None)
        if name is None:
            return ""
        now_s, count = time.monotonic(), statistics[name]
        before_s, before = self._counted.get(bus, (now_s, count))
        self._counted[bus] = (now_s, count)
        rate = max(count - before, 0) / (now_s - before_s) if now_s > before_s else 0.0
        load = f" {statistics['load_percent']:.0f} %" if "load_percent" in statistics else ""
        return f"{bus} {rate:.0f} {name}/s{load}"

    def _on_all_ready(self, text: str) -> None:
        self._was_ready = True
        took_s = time.monotonic() - self._started_s
        self._say(self._styled(f"ready in {took_s:.1f} s; Ctrl-C stops", GREEN) + (f" ({text})" if text else ""))

    def _fail(self, event: Event) -> None:
        how, _, log = event.text.partition("\n")
        lines = [self._styled(f"{event.process} {how}", RED)]
        lines += [f"    {line}" for line in log.splitlines()]
        if event.process:
            lines.append(f"  its log: {_short(self._config.run / 'log' / f'{event.process}.log')}")
        self._erase_load()
        self._print("\n".join(lines), self._err)

    def _say(self, text: str) -> None:
        if not self._is_quiet:
            self._erase_load()
            self._print(text, self._out)

    def _warn(self, text: str) -> None:
        """Print a problem, or its end."""
        self._erase_load()
        self._print(text, self._err if self._is_quiet else self._out)

    def _on_lost_output(self, why: str) -> None:
        """Say on the other output that this one is lost; a reader that has gone (`| head`) wanted no more."""
        if why != os.strerror(EPIPE):
            self._print(f"standard output can't be written: {why}; the rig goes on", self._err)

    @staticmethod
    def _print(text: str, file: TextIO) -> None:
        print(text, file=file, flush=True)

    def _erase_load(self) -> None:
        if self._has_load_line:
            self._out.write(ERASE_LINE)
            self._has_load_line = False

    def _styled(self, text: str, style: str) -> str:
        return f"{style}{text}{PLAIN}" if self._is_terminal and style else text


def _as_typed(line: str, control: str) -> str:
    """Return the line as it has to be typed for this rig and this installation.

    In a shell whose environment is not active, `python` and `fieldrig` may be other programs, or missing.
    """
    program, _, rest = line.partition(" ")
    if program == "fieldrig" and rest.partition(" ")[0] in TALKING and control != DEFAULT_ENDPOINT:
        rest = f"{rest} --control {control}"
    ours = {"python": Path(sys.executable), "fieldrig": Path(sys.executable).with_name("fieldrig")}.get(program)
    found = shutil.which(program)
    if ours is None or not ours.exists() or (found is not None and Path(found) == ours):
        return f"{program} {rest}".rstrip()
    return f"{_short(ours)} {rest}".rstrip()


def _short(path: Path) -> str:
    """Return the path relative to the current folder if that is shorter."""
    try:
        relative = os.path.relpath(path)
    except ValueError:  # another drive, on Windows
        return str(path)
    return min(relative, str(path.absolute()), key=len)


def _clock(time_s: float) -> str:
    return time.strftime("%H:%M:%S", time.localtime(time_s))
