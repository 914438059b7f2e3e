"""The commands that an operator gives the controller with the tool EPAS-4, as words.

Source: PacDrive manual 3636-3648, 3737-3760, 4093-4110, 4219-4280 (digest PD-027, PD-042 to PD-045, PD-119, PD-220,
PD-331).  The protocol of the tool is not public; here its commands are words for `fieldrig set` and tests.  A download
writes the files of PD-043 in their order and at the pace of PD-044.
"""

import logging
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, Final, Protocol

from pydantic import ValidationError

from fieldrig.clock import MS, Clock, Timer
from fieldrig.device import Point, Value
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.configuration.files import Configuration
from fieldrig_devices.max4.configuration.program_file import PROGRAM_FILE, Container
from fieldrig_devices.max4.configuration.version import goes_with, version_of
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.max4.messages.diagnosis import LZS
from fieldrig_devices.max4.plc.plc import Plc
from fieldrig_devices.max4.project import Project
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.system import System

log = logging.getLogger(__name__)

WORDS: Final = (
    "login [VERSION]", "logout", "start", "stop", "reset", "cold start", "online change", "system reset", "download",
    "quit",
    "add mc_4 NAME ADDRESS", "add encoder NAME", "delete NAME", "save parameters",
    "save log FILE", "save and reset log FILE", "reset log", "delete log FILE",
)  # fmt: skip
DOWNLOAD_MS: Final = (0, 5_273, 5_945, 6_155, 6_348, 6_569, 7_357)
"""Times of the files after the first one (manual: 22:56.887, 23:02.160, .832, 23:03.042, .235, .456, 23:04.244)."""


class Owner(Controller, Protocol):
    """The controller, as its commands see it."""

    @property
    def is_on(self) -> bool: ...

    @property
    def system(self) -> System:
        """The system of the present boot."""

    def reset(self) -> None:
        """Boot again."""


class Operations:
    """The commands of one controller."""

    def __init__(self, clock: Clock, owner: Owner, plc: Plc, project: Project, disk: FlashDisk, version: str) -> None:
        """`version` is that of the controller's software."""
        self._clock, self._owner, self._plc = clock, owner, plc
        self._project, self._disk, self._version = project, disk, version_of(version)
        self._timers: list[Timer] = []
        self._last = ""

    def do(self, text: str) -> None:
        """Carry out a command.  ValueError if it is unknown or not possible now."""
        words = text.split()
        self._check_power()
        for name, (counts, action) in self._actions().items():
            begin = name.split()
            if [word.lower() for word in words[: len(begin)]] == begin and len(words) - len(begin) in counts:
                action(*words[len(begin) :])
                self._last = text
                return
        raise ValueError(f"expected {', '.join(WORDS)}, got {text!r}")

    def _check_power(self) -> None:
        if not self._owner.is_on:
            raise ValueError("the controller has no power: expected no command until it boots")

    def points(self) -> Iterator[tuple[str, Point]]:
        def command(words: Value) -> None:
            self.do(str(words))

        yield "command", Point(lambda: self._last, command, "", "command of an operator, in words")

    def cancel(self) -> None:
        for timer in self._timers:
            timer.cancel()
        self._timers.clear()

    def _actions(self) -> dict[str, tuple[tuple[int, ...], Callable[..., Any]]]:
        """Actions by their first words, with the possible numbers of words that follow."""
        owner, logger, plc = self._owner, self._owner.logger, self._plc
        return {
            "login": ((0, 1), self._login),
            "logout": ((0,), lambda: owner.report(Code.LOGOUT, LZS)),
            "start": ((0,), plc.start),
            "stop": ((0,), plc.stop),
            "reset": ((0,), plc.reset),
            "cold start": ((0,), self._cold_start),
            "online change": ((0,), self._online_change),
            "system reset": ((0,), owner.reset),
            "download": ((0,), self._download),
            "quit": ((0,), owner.quit_all),
            "add mc_4": ((2,), self._add_drive),
            "add encoder": ((1,), self._add_encoder),
            "delete log": ((1,), logger.delete),
            "delete": ((1,), self._delete),
            "save parameters": ((0,), self._save_parameters),
            "save and reset log": ((1,), logger.save_and_reset),
            "save log": ((1,), logger.save),
            "reset log": ((0,), logger.reset),
        }

    def _login(self, version: str | None = None) -> None:
        """Log in; a version that the tool gives has to fit (PD-331)."""
        own = self._version
        if version is not None and not goes_with(version_of(version), own):
            raise ValueError(f"expected a version of EPAS-4 with the XX of {own} and no lower YY, got {version}")
        self._owner.report(Code.LOGIN, LZS)

    def _cold_start(self) -> None:
        """Start the program from its beginning, with the start values of all variables (PD-051)."""
        self._plc.reset(is_cold=True)
        self._plc.start()

    # ---- programs

    def reset_cold(self) -> None:
        """End the program; the next start is with the start values of all variables.  ValueError without power."""
        self._check_power()
        self._plc.reset(is_cold=True)

    def erase(self) -> None:
        """End the program and delete it.  ValueError without power."""
        self._check_power()
        self._plc.end()
        self._project.store_program(b"")

    def take(self, files: Sequence[SourceFile], *, is_online: bool) -> None:
        """Load a program of these files, or change the running one to it, and store it.  ValueError without power."""
        self._check_power()
        container = self._project.container(files)
        downloads = self._plc.downloads
        act = downloads.change if is_online else downloads.download
        act(self._plc.order(container), self._storing(container))

    def _storing(self, container: Container) -> Callable[[str], None]:
        """Return what stores a program once it has been loaded."""

        def on_done(problem: str) -> None:
            if not problem:
                self._write(PROGRAM_FILE, container.encode())

        return on_done

    def _online_change(self) -> None:
        """Change the running program to the present sources of the project (PD-225)."""
        container = self._project.sources()
        if container is None:
            raise ValueError("the rig file names no sources: expected program: FILE at this device")
        self._plc.downloads.change(self._plc.order(container), self._storing(container))

    def _download(self) -> None:
        """Load the present sources of the project, if it has any, and write its files."""
        container = self._project.sources()
        if container is None:
            self._write_files(self._project.program)
            return

        def on_done(problem: str) -> None:
            if not problem:
                self._write_files(container.encode())

        self._plc.downloads.download(self._plc.order(container), on_done)

    def _write_files(self, program: bytes) -> None:
        """Write the files of a download in their order, at the pace of the manual."""
        files = self._project.files(self._owner.system.stored_values(), program)
        self.cancel()
        for (name, data), after_ms in zip(files, DOWNLOAD_MS, strict=True):
            when_ns = self._clock.now_ns() + after_ms * MS
            self._timers.append(self._clock.call_at(when_ns, partial(self._write, name, data)))

    def _write(self, name: str, data: bytes) -> None:
        """Write a file.  If the disk refuses it, the log has no entry for this file and the ones after it."""
        try:
            self._disk.write(name, data)
        except ValueError as refused:
            why = str(refused).partition("\n")[0]
            log.warning("%s: the download ends: %s", name, why)
            if name == PROGRAM_FILE:
                self._plc.problem = f"the program is loaded until the next power-off, but not stored: {why}"
            self.cancel()

    # ---- the configuration, which takes effect at the next reset

    def _add_drive(self, name: str, address: str) -> None:
        if not address.isdecimal():
            raise ValueError(f"ring address: expected 1 to 254, got {address}")
        configuration = self._stored()
        drives = {**configuration["drives"], name: {"ring_address": int(address)}}
        self._store({**configuration, "drives": drives})

    def _add_encoder(self, name: str) -> None:
        configuration = self._stored()
        self._store({**configuration, "logic_encoders": [*configuration["logic_encoders"], name]})

    def _delete(self, name: str) -> None:
        configuration = self._stored()
        for key, objects in configuration.items():
            if name in objects:
                rest = (
                    {symbol: drive for symbol, drive in objects.items() if symbol != name}
                    if isinstance(objects, dict)
                    else [symbol for symbol in objects if symbol != name]
                )
                self._store({**configuration, key: rest})
                return
        there = ", ".join(name for objects in configuration.values() for name in objects)
        raise ValueError(f"expected the name of an object ({there or 'there are none'}), got {name}")

    def _stored(self) -> dict[str, Any]:
        return self._project.load().configuration.model_dump(mode="json")

    def _store(self, changed: dict[str, Any]) -> None:
        try:
            configuration = Configuration.model_validate(changed)
        except ValidationError as cause:
            wrong = cause.errors()[0]
            raise ValueError(f"{'.'.join(map(str, wrong['loc']))}: {wrong['msg']}".removeprefix(": ")) from cause
        self._project.store_configuration(configuration)

    def _save_parameters(self) -> None:
        self._project.store_values(self._owner.system.stored_values())
