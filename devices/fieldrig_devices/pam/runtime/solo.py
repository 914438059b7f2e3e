"""An application that runs alone: objects in memory, no node and no ring, and basic cycles on a clock of its own."""

from collections.abc import Mapping, Sequence
from typing import Final

from fieldrig_devices.languages.debugging.debuggee import ProgramState, Reset
from fieldrig_devices.pam.runtime.compiler import Compiled
from fieldrig_devices.pam.runtime.debuggee import PamDebuggee
from fieldrig_devices.pam.runtime.memory_objects import MemoryObjects
from fieldrig_devices.pam.runtime.processor import Limits
from fieldrig_devices.pam.runtime.runtime import Runtime

_MS: Final = 1_000_000
_ANNOUNCEMENTS: Final = "07..M"
"""Messages of the start, which are no events."""


class Solo(PamDebuggee):
    """An application with its clock.  `run_until` moves the clock."""

    def __init__(self, program: Compiled, limits: Limits | None = None) -> None:
        super().__init__()
        self._compiled, self._limits = program, limits
        self.events: list[str] = []
        """Messages of the PAM, in the form that its panel and the debugger show."""
        self._now_ns = 0
        self._is_held = True
        self.load()

    def load(self) -> None:
        """Begin with the application as after power-on."""
        self._runtime = Runtime(self._compiled, self._on_message, self._limits)
        self.objects = MemoryObjects(self._compiled, self._runtime)
        self._runtime.start(self.objects)
        self._start_ns = self._now_ns
        self.attach(self._runtime)

    @property
    def runtime(self) -> Runtime:
        return self._runtime

    def _on_message(self, code: str, details: Sequence[int], text: str) -> None:
        if not code.startswith(_ANNOUNCEMENTS):
            shown = " ".join(f"{detail:X}" for detail in details)
            self.events.append(" ".join(filter(None, [code, shown and f"({shown})", text.removeprefix(f"{code}: ")])))

    @property
    def state(self) -> ProgramState:
        return ProgramState.HELD if self._is_held and not self._runtime.is_stopped else super().state

    def start(self) -> None:
        self._is_held = False

    def stop(self) -> None:
        self._is_held = True

    def reset(self, kind: Reset) -> None:
        self._is_held = True
        self.load()

    def download(self, files: Mapping[str, str], *, is_online: bool) -> None:
        raise ValueError("this application runs alone: expected `fieldrig pam run` with the new file")

    def run_until(self, time_ns: int) -> None:
        """Run all basic cycles up to a time."""
        runtime = self._runtime
        while not self._is_held and not runtime.is_stopped:
            next_ns = self._start_ns + (runtime.cycle_number + 1) * runtime.thirds * _MS // 3
            if next_ns > time_ns:
                break
            self._now_ns = next_ns
            runtime.cycle()
        self._now_ns = time_ns

    @property
    def is_over(self) -> bool:
        """True if a fatal error has stopped the application."""
        return self._runtime.is_stopped
