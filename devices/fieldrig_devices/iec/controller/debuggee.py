"""The program of a controller for the debugging service; each controller adds its commands."""

from collections.abc import Callable
from typing import Protocol

from fieldrig.loop.background import Background
from fieldrig_devices.iec.controller.downloads import Downloads
from fieldrig_devices.iec.debuggee import IecDebuggee
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.tasks.task import Task


class Loader(Protocol):
    """The part of a controller that has its program, as the debugging service sees it."""

    downloads: Downloads
    problem: str
    on_load: Callable[[], None]
    on_stop: Callable[[Task], None]

    @property
    def program(self) -> LoadedProgram | None: ...


class ControllerDebuggee(IecDebuggee):
    """The programs of one controller."""

    def __init__(self, loader: Loader, background: Background) -> None:
        super().__init__(background)
        self._loader = loader
        loader.on_load = lambda: self.on_load()
        loader.on_stop = lambda _task: self.on_stop()

    @property
    def program(self) -> LoadedProgram | None:
        return self._loader.program

    @property
    def progress(self) -> str:
        return self._loader.downloads.progress

    @property
    def problem(self) -> str:
        return self._loader.problem
