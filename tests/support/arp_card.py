"""An ARP card that records the calls of a program, and a bench that runs programs on it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from fieldrig.clock import MS
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.runtime.program import ArpProgram, ProgramState


def _recorded(word: str) -> Callable[..., None]:
    """Make a method that keeps its arguments in `asked`, after `word`."""

    def method(card: "RecordedCard", *arguments: Any) -> None:
        card.asked.append((word, *arguments))

    return method


@dataclass
class RecordedCard:
    """Keeps every call as a tuple in `asked`; a test sets positions, parameters and channels."""

    V: list[int] = field(default_factory=lambda: [0] * 1001)
    F: list[int] = field(default_factory=lambda: [0] * 321)
    I: list[int] = field(default_factory=lambda: [0] * 333)  # noqa: E741
    O: list[int] = field(default_factory=lambda: [0] * 333)  # noqa: E741
    time_ns: int = 0
    asked: list[tuple[Any, ...]] = field(default_factory=list)
    warnings: list[int] = field(default_factory=list)
    error_codes: list[int] = field(default_factory=list)
    positions: dict[int, int] = field(default_factory=lambda: {1: 0, 2: 0})
    speeds: dict[int, int] = field(default_factory=lambda: {1: 0, 2: 0})
    latches: dict[tuple[int, str], int] = field(default_factory=dict)
    general: dict[int, int] = field(default_factory=dict)
    parameters: dict[tuple[int, int], int] = field(
        default_factory=lambda: {(axis, m): raw for axis in (1, 2) for m, raw in ((5, 999_999_999), (6, -999_999_999))}
    )
    channels: dict[int, int] = field(default_factory=dict)

    def now_ns(self) -> int:
        return self.time_ns

    def warn(self, code: int) -> None:
        self.warnings.append(code)

    def fail(self, code: int) -> None:
        self.error_codes.append(code)

    def last_error(self) -> int:
        return self.error_codes[-1] if self.error_codes else 0

    def last_warning(self) -> int:
        return self.warnings[-1] if self.warnings else 0

    def general_parameter(self, number: int) -> int:
        return self.general.get(number, 0)

    def axis_parameter(self, axis: int, number: int) -> int:
        return self.parameters.get((axis, number), 0)

    def set_axis_parameter(self, axis: int, number: int, raw: int) -> None:
        self.parameters[axis, number] = raw

    def position(self, axis: int) -> int:
        return self.positions[axis]

    def preset_position(self, axis: int, raw: int) -> None:
        self.positions[axis] = raw

    def speed(self, axis: int) -> int:
        return self.speeds[axis]

    def latched_rising(self, axis: int) -> int:
        return self.latches.get((axis, "rising"), 0)

    def latched_falling(self, axis: int) -> int:
        return self.latches.get((axis, "falling"), 0)

    limit_speed = _recorded("VEL")
    limit_acceleration = _recorded("ACC")
    limit_deceleration = _recorded("DEC")
    home = _recorded("HOME")
    move_to = _recorded("PAC")
    move_by = _recorded("PRC")
    move_at = _recorded("PVC")
    follow_table = _recorded("PST")
    stop_axis = _recorded("STOP")
    regulate = _recorded("PID")
    arm_cam_switch = _recorded("CAM")
    disarm_cam_switch = _recorded("CAM off")

    def read_analog(self, channel: int) -> int:
        return self.channels.get(channel, 0)

    write_analog = _recorded("DAC")
    store_message = _recorded("MSG")
    clear_screen = _recorded("TERM")
    erase_text = _recorded("TERM")
    show_text = _recorded("TERM")
    print_text = _recorded("PRINT")


class ArpBench:
    """A program on a recorded card, with a control loop of 1 ms and 20 instructions in a slice."""

    def __init__(self, source: str, card: RecordedCard | None = None) -> None:
        """`source` is a whole program, or the instructions of a main program alone."""
        whole = source if "BEG" in source.upper().split() else f"BEG MAIN\n{source}\nEND"
        self.card = card or RecordedCard()
        self.program = ArpProgram(compile_text(whole), self.card)

    def run(self, ms: int = 1, budget: int = 20) -> "ArpBench":
        """Start the program if necessary, and run this many control loops."""
        if self.program.state is ProgramState.HELD:
            self.program.start()
        for _ in range(ms):
            self.program.tick()
            self.program.run(budget)
            self.card.time_ns += MS
        return self
