"""The run time as its programs know it; `runtime.Runtime` implements it."""

from collections.abc import Sequence
from typing import Any, Protocol

from fieldrig_devices.languages.resumable import Code
from fieldrig_devices.pam.runtime.item import Item, Pending, Value
from fieldrig_devices.pam.runtime.lower.lowered import SequenceCode
from fieldrig_devices.pam.runtime.processor import Processor, Program
from fieldrig_devices.pam.runtime.readings import Readings
from fieldrig_devices.pam.runtime.schedule import Schedule
from fieldrig_devices.pam.runtime.waits import Gate
from fieldrig_devices.pam.runtime.watches import Watches


class ProgramKernel(Protocol):
    """The services of the run time for tasks, actions and equations."""

    readings: Readings
    code: Code
    cells: list[Any]
    """The values of all variables and equations, then the formal parameters."""
    schedule: Schedule
    watches: Watches
    processor: Processor
    gates: dict[tuple[str, str], Gate]
    """The gates of CONDITION DUPL_START (`TaskItem.gate_of`)."""
    is_working: bool
    """True when all POWERON parts have finished (PAML-264)."""
    is_stopped: bool
    """True after a fatal message."""

    @property
    def thirds(self) -> int:
        """BASIC_PAM_CYCLE in thirds of a millisecond."""

    def active(self, name: str) -> Sequence[int]:
        """Return the items of an object, from 0, whose components are on the ring (G-46)."""

    def connect(self, blocks: Sequence[Item]) -> None:
        """Make and activate a pipe, from the output block to the input block (PAML-403)."""

    def later(self, slot: int, answer: Value | Pending) -> bool:
        """Keep the answer to an inquiry of the present statement; True if it is still under way."""

    def poke(self, cell: int, value: Value) -> None:
        """Write a variable, and look at what waits for it."""

    def run(self, program: Program) -> None:
        """Run a program until it waits, ends or gives way."""

    def cover(self, mark: int) -> None:
        """Pass a mark of coverage that generated code does not pass itself."""

    def run_routines(self) -> None:
        """Run the connected routines that wait (PAML-274)."""

    def report(self, code: str, details: Sequence[int] = ()) -> None:
        """Show a system message of section 14, such as `07..E021`, with its details."""

    def on_stopped(self) -> None:
        """A program has reached a breakpoint."""

    def has_stopped(self) -> bool:
        """Return whether the application has just been stopped."""

    def stop_by(self, code: str, details: Sequence[int], text: str, sequence: SequenceCode) -> None:
        """Stop the application because of an error in its declarations, at a sequence that cannot start."""
