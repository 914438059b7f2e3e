"""The PLC of the MAx-4 for the debugging service.

Source: PacDrive manual 3737-3785, 4011-4048, 6430-6436 (digest PD-220 to PD-225).  A trace is recorded inside the
real-time process (6967-6969), so it has a sample in each of its cycles.
"""

from collections.abc import Callable, Mapping

from fieldrig.loop.background import Background
from fieldrig_devices.iec.controller.debuggee import ControllerDebuggee
from fieldrig_devices.languages.debugging.debuggee import Reset
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.operations import Operations
from fieldrig_devices.max4.plc.plc import Plc


class PlcDebuggee(ControllerDebuggee):
    """The programs of one controller."""

    def __init__(self, controller: Controller, plc: Plc, operations: Operations, background: Background) -> None:
        super().__init__(plc, background)
        self._controller, self._operations = controller, operations
        self._sample: Callable[[], None] | None = None
        self._is_sampled = False

    @property
    def on_sample(self) -> Callable[[], None] | None:
        return self._sample

    @on_sample.setter
    def on_sample(self, action: Callable[[], None] | None) -> None:
        self._sample = action
        if action is not None and not self._is_sampled:
            self._is_sampled = True
            self._controller.each_cycle(self._on_cycle)

    def _on_cycle(self) -> None:
        if self._sample is not None:
            self._sample()

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
