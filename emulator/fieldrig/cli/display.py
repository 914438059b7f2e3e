"""The output of `fieldrig up`: one line for each connection, what happens, and on a terminal one line with the load."""

import asyncio
import os
import shutil
import sys
import time
from collections.abc import Mapping
from errno import EPIPE
from typing import Any, TextIO

from fieldrig.cli.reach import as_typed, connections, short
from fieldrig.cli.width import output_width
from fieldrig.config.rig_file import RigConfig
from fieldrig.control.events import Event
from fieldrig.control.messages import Control
from fieldrig.control.notices import in_words, taken
from fieldrig.outside.page_seat import PageRole
from fieldrig.points.values import counted
from fieldrig.system.steady_output import steady
from fieldrig.text.listed import listed

REFRESH_S = 1.0
ERASE_LINE = "\r\x1b[K"
BOLD, DIM, RED, GREEN, YELLOW, PLAIN = "\x1b[1m", "\x1b[2m", "\x1b[31m", "\x1b[32m", "\x1b[33m", "\x1b[0m"
COLOURS = {"failed": RED, "died": YELLOW, "gone": YELLOW, "late": YELLOW, "warning": YELLOW, "ready": GREEN}
COUNTERS = ("frames", "requests", "messages", "characters")
"""The statistics of buses that are shown as a rate."""


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
        self._told = set[tuple[str, str]]()
        """The faults and conditions that are present, by part and key."""

    def introduce(self, processes: int, pages: Mapping[PageRole, str]) -> None:
        """Print what the rig is and how to reach it; `pages` are the addresses of its page."""
        config = self._config
        with_processes = f", {counted(processes, 'process', 'processes')}" if processes else ""
        self._say(
            f"{self._styled(config.name, BOLD)}: time: {config.time}{with_processes}, control at {config.control}\n"
        )
        ways = list(connections(config))
        name, protocol, address = (max((len(way[column]) for way in ways), default=0) for column in range(3))
        room = output_width()
        for way in ways:
            words = f"  {way.protocol:{protocol}}  {way.address:{address}}  "
            devices = listed(way.devices, room - 2 - name - len(words))
            self._say(f"  {self._styled(way.bus.ljust(name), BOLD)}{words}{devices}".rstrip())
        devices = listed(list(config.devices), room - len("devices: "))
        self._say(f"\ndevices: {devices}" if ways else f"devices: {devices}")
        self._say(f"commands for each bus and device: {as_typed('fieldrig help NAME', config.control)}")
        for role, page in pages.items():
            self._say(f"page to {role}:".ljust(len("page to operate: ")) + self._styled(page, BOLD))
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

    def notice(self, _part: str, message: Any) -> None:
        """Print that a fault or a condition of a part begins or ends.  Every end of a direct bus tells of the same."""
        notice = taken(message)
        if notice is None or self._signals:
            return
        told = (notice.part, notice.key)
        if notice.is_over is (told in self._told):
            (self._told.discard if notice.is_over else self._told.add)(told)
            self._say(f"{_clock(time.time())}  {self._styled(notice.part, YELLOW)}: {in_words(notice)}")

    def on_signal(self) -> None:
        self._signals += 1
        if self._signals == 2:
            self._say("ending everything at once")

    def warn(self, text: str) -> None:
        """Print a warning of the whole rig, before it starts."""
        self._warn(f"{self._styled('warning', YELLOW)}: {text.replace(chr(10), chr(10) + '    ')}")

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

    def _show_load(self, loads: Mapping[str, Mapping[str, float]]) -> None:
        words = [self._load(bus, loads[bus]) for bus in self._config.buses if bus in loads]
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
            lines.append(f"  its log: {short(self._config.run / 'log' / f'{event.process}.log')}")
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
            self._print(f"standard output cannot be written: {why}; the rig goes on", self._err)

    @staticmethod
    def _print(text: str, file: TextIO) -> None:
        print(text, file=file, flush=True)

    def _erase_load(self) -> None:
        if self._has_load_line:
            self._out.write(ERASE_LINE)
            self._has_load_line = False

    def _styled(self, text: str, style: str) -> str:
        return f"{style}{text}{PLAIN}" if self._is_terminal and style else text


def _clock(time_s: float) -> str:
    return time.strftime("%H:%M:%S", time.localtime(time_s))
