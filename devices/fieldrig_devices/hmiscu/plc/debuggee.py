"""The program of the controller for the debugging service.

A trace has a sample at the end of each cycle of a task.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fieldrig.loop.background import Background
from fieldrig_devices.hmiscu.plc.mast import MastProgram
from fieldrig_devices.iec.debuggee import IecDebuggee
from fieldrig_devices.languages.debugging.debuggee import Reset
from fieldrig_devices.languages.source_file import SourceFile

if TYPE_CHECKING:
    from fieldrig_devices.hmiscu.plc.plc import Plc


class PlcDebuggee(IecDebuggee):
    """The program of one controller."""

    def __init__(self, plc: "Plc", background: Background) -> None:
        super().__init__(background)
        self._plc = plc
        plc.on_stop = lambda task: self.on_stop()

    @property
    def program(self) -> MastProgram | None:
        return self._plc.program

    @property
    def progress(self) -> str:
        return self._plc.downloads.progress

    @property
    def problem(self) -> str:
        return self._plc.problem

    def start(self) -> None:
        self._loaded()
        self._plc.run()

    def stop(self) -> None:
        self._plc.stop()

    def reset(self, kind: Reset) -> None:
        if kind is Reset.ORIGIN:
            self._plc.unload()
        else:
            self._plc.reset(is_cold=kind is Reset.COLD)

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        sources = tuple(SourceFile(name, text) for name, text in files.items())
        if is_online:
            self._plc.downloads.change(sources)
        else:
            self._plc.downloads.download(sources)

    def sample(self) -> None:
        """Take a sample for a trace."""
        if self.on_sample is not None:
            self.on_sample()
