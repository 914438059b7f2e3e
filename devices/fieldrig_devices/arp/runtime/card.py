"""The interface of the card to the program that runs on it.

Values are raw integers (value x 1000) unless a name says otherwise; axes, channels, timers and terminals are numbered
as on the card.  Arguments are within the ranges of the manual, unless a method says that it checks them itself: the
run-time system has refused all others with W03.  The card decides whether an instruction is executed at all (kind of
axis, output owned by diagnostics) and may itself warn or fail.  No method waits or raises.
"""

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class CamSwitch:
    """Arguments of CAMn; `letter` and `number` name the flag or output that it drives (manual 5.11)."""

    axis: int
    set_at: int
    reset_at: int
    is_inverted: bool
    letter: str
    number: int


@dataclass(frozen=True, slots=True)
class Shown:
    """Arguments of TERM with a message.

    `line` and `column` may be off the screen; the visible part is shown (digest I-27).
    """

    line: int
    column: int
    height: int
    message: int
    variable: int | None = None
    mode: str = ""
    """Mode "E" or "P" if the operator may change the variable."""


class Card(Protocol):
    V: list[int]
    """Variables V1 to V1000; element 0 is not used."""
    F: list[int]
    """Flags F1 to F320 as 0 or 1; the program writes only R/W flags."""
    I: list[int]  # noqa: E741  the manual's letter
    """Inputs by number, I101 to I332, as 0 or 1."""
    O: list[int]  # noqa: E741
    """Outputs by number, O101 to O332, as 0 or 1."""

    # The program keeps references to these four lists; the card changes their elements, never the lists.

    def now_ns(self) -> int: ...
    def warn(self, code: int) -> None:
        """Report a warning, 201 to 204."""

    def fail(self, code: int) -> None:
        """Report an error: 111 and 112, which stop the program, or 113."""

    def last_error(self) -> int:
        """Code of the most recent error; 0 if there is none."""

    def last_warning(self) -> int: ...

    def general_parameter(self, number: int) -> int: ...
    def axis_parameter(self, axis: int, number: int) -> int: ...
    def set_axis_parameter(self, axis: int, number: int, raw: int) -> None:
        """Write a parameter.  It checks the value itself: a value out of range is refused with W03."""

    def position(self, axis: int) -> int: ...
    def preset_position(self, axis: int, raw: int) -> None: ...
    def speed(self, axis: int) -> int: ...
    def latched_rising(self, axis: int) -> int: ...
    def latched_falling(self, axis: int) -> int: ...

    def limit_speed(self, axis: int, percent: int) -> None: ...
    def limit_acceleration(self, axis: int, percent: int) -> None: ...
    def limit_deceleration(self, axis: int, percent: int) -> None: ...
    def home(self, axis: int) -> None: ...
    def move_to(self, axis: int, target: int) -> None: ...
    def move_by(self, axis: int, distance: int) -> None: ...
    def move_at(self, axis: int, percent: int) -> None: ...
    def follow_table(self, master: int, slave: int, first: int) -> None:
        """Execute PST.  It checks all arguments itself, including axes and table (E13)."""

    def stop_axis(self, axis: int) -> None: ...

    def regulate(self, cell: int, output: int, first: int) -> None:
        """Execute PID, with its 25 variables from V`first`."""

    def arm_cam_switch(self, number: int, cam: CamSwitch) -> None: ...
    def disarm_cam_switch(self, number: int) -> None: ...

    def read_analog(self, channel: int) -> int: ...
    def write_analog(self, channel: int, volt: int, slope_ms: int) -> None:
        """Execute DAC.  `slope_ms` is the time for a change of 10 V; 0 means at once."""

    def store_message(self, number: int, text: str) -> None: ...
    def clear_screen(self) -> None: ...
    def erase_text(self, line: int, column: int) -> None: ...
    def show_text(self, shown: Shown) -> None: ...
    def print_text(self, message: int, variable: int | None) -> None:
        """Print a message.  Message 0 is date and time."""
