"""The program of the controller for the debugging service.

A trace has a sample at the end of each cycle of a task.
"""

from collections.abc import Mapping

from fieldrig.loop.background import Background
from fieldrig_devices.hmiscu.plc.plc import Plc
from fieldrig_devices.iec.controller.debuggee import ControllerDebuggee
from fieldrig_devices.languages.debugging.debuggee import Reset
from fieldrig_devices.languages.source_file import SourceFile


class PlcDebuggee(ControllerDebuggee):
    """The program of one controller."""

    def __init__(self, plc: Plc, background: Background) -> None:
        super().__init__(plc, background)
        self._plc = plc

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
        order = self._plc.compiler.order([SourceFile(name, text) for name, text in files.items()])
        if is_online:
            self._plc.downloads.change(order)
        else:
            self._plc.downloads.download(order)
