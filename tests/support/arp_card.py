"""An ARP card that records what a program asks of it, and a bench that runs programs on it."""

from dataclasses import dataclass, field
from typing import Any

from fieldrig.clock import MS
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.runtime.card import Cam, Shown
from fieldrig_devices.arp.runtime.program import ArpProgram, ProgramState


@dataclass
class RecordedCard:
    """Keeps every call as a tuple in `asked`; positions, parameters and channels are what a test puts there."""

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

    def limit_speed(self, axis: int, percent: int) -> None:
        self.asked.append(("VEL", axis, percent))

    def limit_acceleration(self, axis: int, percent: int) -> None:
        self.asked.append(("ACC", axis, percent))

    def limit_deceleration(self, axis: int, percent: int) -> None:
        self.asked.append(("DEC", axis, percent))

    def home(self, axis: int) -> None:
        self.asked.append(("HOME", axis))

    def move_to(self, axis: int, target: int) -> None:
        self.asked.append(("PAC", axis, target))

    def move_by(self, axis: int, distance: int) -> None:
        self.asked.append(("PRC", axis, distance))

    def move_at(self, axis: int, percent: int) -> None:
        self.asked.append(("PVC", axis, percent))

    def follow_table(self, master: int, slave: int, first: int) -> None:
        self.asked.append(("PST", master, slave, first))

    def stop_axis(self, axis: int) -> None:
        self.asked.append(("STOP", axis))

    def regulate(self, cell: int, output: int, first: int) -> None:
        self.asked.append(("PID", cell, output, first))

    def arm_cam(self, number: int, cam: Cam) -> None:
        self.asked.append(("CAM", number, cam))

    def disarm_cam(self, number: int) -> None:
        self.asked.append(("CAM off", number))

    def read_analog(self, channel: int) -> int:
        return self.channels.get(channel, 0)

    def write_analog(self, channel: int, volt: int, slope_ms: int) -> None:
        self.asked.append(("DAC", channel, volt, slope_ms))

    def store_message(self, number: int, text: str) -> None:
        self.asked.append(("MSG", number, text))

    def clear_screen(self) -> None:
        self.asked.append(("TERM",))

    def erase_text(self, line: int, column: int) -> None:
        self.asked.append(("TERM", line, column))

    def show_text(self, shown: Shown) -> None:
        self.asked.append(("TERM", shown))

    def print_text(self, message: int, variable: int | None) -> None:
        self.asked.append(("PRINT", message, variable))


class ArpBench:
    """A program on a recorded card, with a control loop of 1 ms and 20 instructions in a slice."""

    def __init__(self, source: str, card: RecordedCard | None = None) -> None:
        """`source` is a whole program, or the instructions of a main program alone."""
        whole = source if "BEG" in source.upper().split() else f"BEG MAIN\n{source}\nEND"
        self.card = card or RecordedCard()
        self.program = ArpProgram(compile_text(whole), self.card)

    def run(self, ms: int = 1, budget: int = 20) -> "ArpBench":
        """Start it if it was not, and let this many control loops pass."""
        if self.program.state is ProgramState.HELD:
            self.program.start()
        for _ in range(ms):
            self.program.tick()
            self.program.run(budget)
            self.card.time_ns += MS
        return self
