"""The PLC of the MAx-4 for the debugging service.

Source: PacDrive manual 3737-3785, 4011-4048, 6430-6436 (digest PD-220 to PD-225).  A trace has a sample in each cycle
of the real-time process (6967-6969), which is the cycle that recordings of a MAx-4 have.
"""

from collections.abc import Mapping

from fieldrig.loop.background import Background
from fieldrig_devices.iec.controller.debuggee import ControllerDebuggee
from fieldrig_devices.languages.debugging.debuggee import Reset
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.operations import Operations
from fieldrig_devices.max4.plc.plc import Plc


class PlcDebuggee(ControllerDebuggee):
    """The programs of one controller."""

    def __init__(self, plc: Plc, operations: Operations, background: Background) -> None:
        super().__init__(plc, background)
        self._operations = operations

    def start(self) -> None:
        self._operations.do("start")

    def stop(self) -> None:
        self._operations.do("stop")

    def reset(self, kind: Reset) -> None:
        match kind:
            case Reset.WARM:
                self._operations.do("reset")
            case Reset.COLD:
                self._operations.reset_cold()
            case Reset.ORIGIN:
                self._operations.erase()

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        self._operations.take([SourceFile(name, text) for name, text in files.items()], is_online=is_online)
