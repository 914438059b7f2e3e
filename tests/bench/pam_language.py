"""Programs of the PAM against CPython doing the same by hand, unchecked: nanoseconds of CPU time a statement.

By hand means what a Python programmer would write: variables that last are attributes of an object, objects of the
machine are called by their methods, `while` and `if` for the same loops and choices; with no check of a range, and no
means to stop it.  A quotient is truncated toward zero by hand as well, because its sign is not known.
"""

import statistics
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from pam_bench import PamBench, sequence  # noqa: E402  found in the folder of the tests' support
from report import Report, progress  # noqa: E402  found beside this file
from turns import REPEATS, shown, take_turns  # noqa: E402

from fieldrig_devices.pam.runtime.item import Value  # noqa: E402
from fieldrig_devices.pam.runtime.processor import Limits  # noqa: E402

ROUNDS = 20_000
WARMING = 10
"""Short runs before the first turn: CPython adapts a function with a `while` loop only after some calls."""
VARIABLES = """
COMMON WORD_VAR i; COMMON WORD_VAR rounds; COMMON WORD_VAR count; COMMON WORD_VAR sum; COMMON WORD_VAR last;
COMMON WORD_VAR small; COMMON WORD_VAR limit; COMMON REAL_VAR a; COMMON REAL_VAR b; COMMON REAL_VAR k;
COMMON REAL_VAR goal; COMMON REAL_VAR step; COMMON FLAG_VAR begins; COMMON FLAG_VAR ends; COMMON FLAG_VAR motor;
COMMON FLAG_VAR alarm; COMMON FLAG_VAR lamp;
SINK SNK_a; END CONVERTER CNV_a; DESTINATION = SNK_a; MODE = VALUE; END
"""
INTEGER = """
limit <- 900000;
LOOP
  i <- i + 1; count <- count + 1; sum <- sum + count * 3 - last; last <- sum / 7; small <- small + 5;
  IF count >= limit THEN count <- 0; END_IF
END_LOOP i = rounds;
"""
REAL = """
k <- 0.125; goal <- 250.0;
LOOP
  i <- i + 1; step <- (goal - a) * k; a <- a + step * 0.01; b <- b * 0.9 + a * 0.1;
  IF a > 240.0 THEN a <- 0.0; END_IF
END_LOOP i = rounds;
"""
FLAGS = """
LOOP
  i <- i + 1; motor <- (begins + motor) * !ends; alarm <- motor * (i > 100) + ends; lamp <- alarm <> motor;
  IF lamp THEN begins <- invert; ELSE ends <- invert; END_IF
END_LOOP i = rounds;
"""
OF_MACHINE = """
LOOP
  i <- i + 1; SBO_a <- SBI_a; IF SBI_b THEN SBO_a <- 0; END_IF
  SDO_a <- count; count <- SDO_a + 1; IF count > 50 THEN count <- 0; END_IF lamp <- CNV_a ? ready;
END_LOOP i = rounds;
"""


class Plain:
    """An object of the machine that does as little as possible."""

    def __init__(self) -> None:
        self._value: Value = 0

    def value(self) -> Value:
        return self._value

    def set_value(self, value: Value) -> None:
        self._value = value

    def ask(self, function: str, arguments: Sequence[Any]) -> Value:
        return True


class Machine:
    """The variables of a program, and its objects."""

    def __init__(self) -> None:
        self.i = self.count = self.sum = self.last = self.small = 0
        self.limit = 900_000
        self.a = self.b = self.step = 0.0
        self.k, self.goal = 0.125, 250.0
        self.begins = self.ends = self.motor = self.alarm = self.lamp = False
        self.output, self.input, self.other, self.digital, self.converter = (Plain() for _ in range(5))


def integer_by_hand(m: Machine, rounds: int) -> None:
    while m.i != rounds:
        m.i += 1
        m.count += 1
        m.sum = m.sum + m.count * 3 - m.last
        m.last = m.sum // 7 if m.sum >= 0 else -(-m.sum // 7)
        m.small += 5
        if m.count >= m.limit:
            m.count = 0


def real_by_hand(m: Machine, rounds: int) -> None:
    while m.i != rounds:
        m.i += 1
        m.step = (m.goal - m.a) * m.k
        m.a = m.a + m.step * 0.01
        m.b = m.b * 0.9 + m.a * 0.1
        if m.a > 240.0:
            m.a = 0.0


def flags_by_hand(m: Machine, rounds: int) -> None:
    while m.i != rounds:
        m.i += 1
        m.motor = (m.begins or m.motor) and not m.ends
        m.alarm = (m.motor and m.i > 100) or m.ends
        m.lamp = m.alarm != m.motor
        if m.lamp:
            m.begins = not m.begins
        else:
            m.ends = not m.ends


def objects_by_hand(m: Machine, rounds: int) -> None:
    while m.i != rounds:
        m.i += 1
        m.output.set_value(m.input.value())
        if m.other.value():
            m.output.set_value(value=False)
        m.digital.set_value(m.count)
        m.count = int(m.digital.value()) + 1
        if m.count > 50:
            m.count = 0
        m.lamp = bool(m.converter.ask("ready", ()))


@dataclass(frozen=True)
class Case:
    name: str
    statements: str
    count: int
    """Number of statements in one round, the end of the loop included."""
    by_hand: Callable[[Machine, int], None]


CASES = (
    Case("integers", INTEGER, 7, integer_by_hand),
    Case("real numbers", REAL, 6, real_by_hand),
    Case("flags", FLAGS, 7, flags_by_hand),
    Case("objects", OF_MACHINE, 8, objects_by_hand),
)
PLAIN = ("SBO_a", "SBI_a", "SBI_b", "SDO_a", "CNV_a")


def program_of(case: Case) -> Callable[[int], None]:
    """Return a function that runs the program of a case from its beginning to its end, for a number of rounds."""
    bench = PamBench(VARIABLES + sequence(case.statements), limits=Limits(10**9))
    bench.objects.items |= {name: [Plain()] for name in PLAIN}  # type: ignore[list-item]
    bench.restart()
    bench.run()
    (task,) = bench.runtime.tasks
    first = list(bench.runtime.cells)

    def run(rounds: int) -> None:
        bench.runtime.cells[:] = first
        bench["rounds"] = rounds
        task.start(task.code.sequences["SEQ_a"])
        task.wake()
        bench.run()
        assert not task.is_alive, bench.errors

    return run


def turns_of(case: Case) -> tuple[list[float], list[float]]:
    """Return nanoseconds a statement in each turn, by hand and of the PAM; both are warm."""
    program = program_of(case)

    def by_hand(rounds: int) -> None:
        case.by_hand(Machine(), rounds)

    for _ in range(WARMING):
        by_hand(WARMING)
        program(WARMING)
    own, taken = take_turns(case.count * ROUNDS, partial(by_hand, ROUNDS), [partial(program, ROUNDS)])
    return own, taken


def run() -> Report:
    report = Report(
        "Programs of the PAM",
        "This table shows nanoseconds of CPU time per statement in short loops, and their ratio to CPython doing the"
        f" same by hand, unchecked: {ROUNDS:,} rounds, the best of {REPEATS} turns, and mean and standard deviation of"
        " the ratio in each turn.",
        ("program", "by hand", "of the PAM", "ratio, at most 3", "ratio in each turn"),
    )
    found = []
    for case in CASES:
        progress(f"PAM: {case.name}")
        own, taken = turns_of(case)
        found.append(min(taken) / min(own))
        ratios = [one / other for one, other in zip(taken, own, strict=True)]
        report.add(case.name, f"{min(own):.0f}", f"{min(taken):.0f}", f"{found[-1]:.2f}", shown(ratios, ".2f"))
    report.notes.append(f"geometric mean of the ratios, at most 2: {statistics.geometric_mean(found):.2f}")
    report.notes.append(f"worst ratio, at most 3: {max(found):.2f}")
    return report


if __name__ == "__main__":
    print(run().markdown())
