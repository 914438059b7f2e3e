"""What a program asks of the card it runs on.

Values are raw integers (value x 1000) unless a name says otherwise; axes, channels, timers and terminals are numbered
as on the card.  What arrives here is within the ranges of the manual, unless a method says that it checks itself: the
run-time has refused the rest with W03.  The card decides whether an instruction is executed at all (kind of axis,
output owned by diagnostics) and may warn or fail itself.  Nothing here waits, and nothing raises.
"""

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Cam:
    """CAMn: `letter` and `number` name the flag or output that it drives (manual 5.11)."""

    axis: int
    set_at: int
    reset_at: int
    is_inverted: bool
    letter: str
    number: int


@dataclass(frozen=True, slots=True)
class Shown:
    """TERM with a message.  `line` and `column` may lie off the screen: what fits is shown (digest I-27)."""

    line: int
    column: int
    height: int
    message: int
    variable: int | None = None
    mode: str = ""
    """"E" or "P" if the operator may change the variable."""


class Card(Protocol):
    V: list[int]
    """V1 to V1000; element 0 is not used."""
    F: list[int]
    """F1 to F320 as 0 or 1; the program writes those that are R/W only."""
    I: list[int]  # noqa: E741  the manual's letter
    """By their numbers, I101 to I332, as 0 or 1."""
    O: list[int]  # noqa: E741
    """By their numbers, O101 to O332, as 0 or 1."""

    # The program keeps these four lists; the card changes their elements, never the lists.

    def now_ns(self) -> int: ...
    def warn(self, code: int) -> None:
        """201 to 204."""

    def fail(self, code: int) -> None:
        """111 and 112, after which the program stands; 113."""

    def last_error(self) -> int:
        """The code of the most recent error, 0 without one."""

    def last_warning(self) -> int: ...

    def general_parameter(self, number: int) -> int: ...
    def axis_parameter(self, axis: int, number: int) -> int: ...
    def set_axis_parameter(self, axis: int, number: int, raw: int) -> None:
        """Checks itself: a value out of range is refused with W03."""

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
        """PST.  Checks everything itself, axes and table too (E13)."""

    def stop_axis(self, axis: int) -> None: ...

    def regulate(self, cell: int, output: int, first: int) -> None:
        """PID, with its 25 variables from V`first`."""

    def arm_cam(self, number: int, cam: Cam) -> None: ...
    def disarm_cam(self, number: int) -> None: ...

    def read_analog(self, channel: int) -> int: ...
    def write_analog(self, channel: int, volt: int, slope_ms: int) -> None:
        """`slope_ms` is the time for a change of 10 V; 0: at once."""

    def store_message(self, number: int, text: str) -> None: ...
    def clear_screen(self) -> None: ...
    def erase_text(self, line: int, column: int) -> None: ...
    def show_text(self, shown: Shown) -> None: ...
    def print_text(self, message: int, variable: int | None) -> None:
        """Message 0 is date and time."""
