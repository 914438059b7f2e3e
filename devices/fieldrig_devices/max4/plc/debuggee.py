"""The PLC of the MAx-4 for the debugging service.

Source: PacDrive manual 3737-3785, 4011-4048, 6430-6436 (digest PD-220 to PD-225).  A trace is recorded inside the
real-time process (6967-6969), so it has a sample in each of its cycles.
"""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from fieldrig.loop.background import Background
from fieldrig_devices.iec.debuggee import IecDebuggee
from fieldrig_devices.languages.debugging.debuggee import Reset
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.configuration.program_file import Container
from fieldrig_devices.max4.plc.loaded import RetainingProgram

if TYPE_CHECKING:
    from fieldrig_devices.max4.controller import Max4


class PlcDebuggee(IecDebuggee):
    """The programs of one controller."""

    def __init__(self, controller: "Max4", background: Background) -> None:
        super().__init__(background)
        self._controller, self._plc = controller, controller.plc
        self._sample: Callable[[], None] | None = None
        self._is_sampled = False
        self._plc.on_load = lambda: self.on_load()
        self._plc.on_stop = lambda _task: self.on_stop()

    @property
    def program(self) -> RetainingProgram | None:
        return self._plc.program

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

    @property
    def progress(self) -> str:
        return self._plc.progress

    @property
    def problem(self) -> str:
        return self._plc.problem

    def start(self) -> None:
        self._powered().operations.do("start")

    def stop(self) -> None:
        self._powered().operations.do("stop")

    def reset(self, kind: Reset) -> None:
        controller = self._powered()
        match kind:
            case Reset.WARM:
                controller.operations.do("reset")
            case Reset.COLD:
                controller.plc.reset(is_cold=True)
            case Reset.ORIGIN:
                controller.plc.end()
                controller.project.store_program(b"")

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        controller = self._powered()
        sources = tuple(SourceFile(name, text) for name, text in files.items())
        container = Container(sources, controller.settings.dialect, controller.settings.resource)

        def on_done(problem: str) -> None:
            if not problem:
                controller.operations.write_program(container.encode())

        if is_online:
            controller.plc.change(container, on_done)
        else:
            controller.plc.download(container, on_done)

    def _powered(self) -> "Max4":
        if not self._controller.is_on:
            raise ValueError("the controller has no power: expected no command until it boots")
        return self._controller
