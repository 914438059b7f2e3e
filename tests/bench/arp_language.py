"""The ARP's BASIC against CPython doing the same by hand, unchecked: nanoseconds a statement.

By hand means what a Python programmer would write for the same fixed-point integers, `while` and `if` for GOTO, on the
same lists, with no range check, no saturation and no means to stop it.  Products, quotients and remainders are
truncated toward zero by hand as well, wherever the sign of an operand is not known.

A program runs in one piece, and in the slices that a card gives it: as many instructions as one control period leaves.
"""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from arp_card import ArpBench
from report import Report, progress

from fieldrig.clock import MS
from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.language.compiler import Compiled
from fieldrig_devices.arp.parameters import GENERAL, PARAMETERS, Par
from fieldrig_devices.arp.runtime.slices import Costs, Slices

ROUNDS = 20_000
REPEATS = 7

# Each program is a loop of as many statements as it says, GOTO included.
COUNT = """\
LOOP:
V1 += 1
V2 == V1 + V3
V3 == V2 - V1
IF V1 < 900000, LOOP
V1 == 0
GOTO LOOP"""

CALCULATE = """\
LOOP:
V1 == V2 * V3
V4 == V1 / V5 + V6
V7 == (V4 + V1) * 0.5
V2 += 0.001
V8 == V7 - V4
GOTO LOOP"""

LOGIC = """\
LOOP:
F10 == I101 & F11 | !F12
IF F10 = HI, SET O101
IF F10 = LO, RES O101
V1 == @FLAG_WORD
V2 == V1 & H00FF
F11 ^= 1
GOTO LOOP""".replace("@FLAG_WORD", "V9")

MACHINE = """\
LOOP:
V1 += 1
IF V1 <= 500, L1
V1 == 0
L1:
IF I101 = HI, L2
V2 == V1 * 2.5 + V10
IF V2 > V3, SET O102
IF V2 <= V3, RES O102
L2:
V4 == V[V5]
V4 += V2
IF F20 = HI, V4 == 0
GOTO LOOP"""

OPERATIONS = """\
LOOP:
V1 == V2 * V3
V4 == V1 / V5
V7 == V4 % V3
V2 += 0.001
GOTO LOOP"""

CALLS = """\
BEG MAIN
LOOP:
V1 += 1
CALL SUB
V3 == V2 + V1
GOTO LOOP
END
BEG SUB
V2 == V1 - 1
V4 += 0.001
END"""


def count_by_hand(v: list[int], f: list[int], i: list[int], o: list[int], rounds: int) -> None:
    for _ in range(rounds):
        v[1] += 1000
        v[2] = v[1] + v[3]
        v[3] = v[2] - v[1]
        if v[1] < 900000000:
            continue
        v[1] = 0


def calculate_by_hand(v: list[int], f: list[int], i: list[int], o: list[int], rounds: int) -> None:
    for _ in range(rounds):
        v[1] = v[2] * v[3] // 1000
        v[4] = v[1] * 1000 // v[5] + v[6]
        v[7] = (v[4] + v[1]) * 500 // 1000
        v[2] += 1
        v[8] = v[7] - v[4]


def logic_by_hand(v: list[int], f: list[int], i: list[int], o: list[int], rounds: int) -> None:
    for _ in range(rounds):
        f[10] = i[101] & f[11] | (f[12] ^ 1)
        if f[10]:
            o[101] = 1
        if not f[10]:
            o[101] = 0
        v[1] = v[9]
        v[2] = v[1] & 0xFF
        f[11] ^= 1


def machine_by_hand(v: list[int], f: list[int], i: list[int], o: list[int], rounds: int) -> None:
    for _ in range(rounds):
        v[1] += 1000
        if v[1] > 500000:
            v[1] = 0
        if not i[101]:
            v[2] = v[1] * 2500 // 1000 + v[10]
            if v[2] > v[3]:
                o[102] = 1
            if v[2] <= v[3]:
                o[102] = 0
        v[4] = v[v[5] // 1000]
        v[4] += v[2]
        if f[20]:
            v[4] = 0


def operations_by_hand(v: list[int], f: list[int], i: list[int], o: list[int], rounds: int) -> None:
    for _ in range(rounds):
        product = v[2] * v[3]
        v[1] = product // 1000 if product >= 0 else -(-product // 1000)
        dividend, divisor = v[1] * 1000, v[5]
        v[4] = dividend // divisor if (dividend >= 0) == (divisor > 0) else -(-dividend // divisor)
        dividend, divisor = v[4], v[3]
        v[7] = dividend % divisor if (dividend >= 0) == (divisor > 0) else -(-dividend % divisor)
        v[2] += 1


def calls_by_hand(v: list[int], f: list[int], i: list[int], o: list[int], rounds: int) -> None:
    def sub() -> None:
        v[2] = v[1] - 1000
        v[4] += 1

    for _ in range(rounds):
        v[1] += 1000
        sub()
        v[3] = v[2] + v[1]


@dataclass(frozen=True)
class Case:
    name: str
    source: str
    statements: int
    """Number of statements in one round."""
    by_hand: Callable[[list[int], list[int], list[int], list[int], int], None]


CASES = (
    Case("counting and comparing", COUNT, 4, count_by_hand),
    Case("calculating", CALCULATE, 6, calculate_by_hand),
    Case("multiply, divide, remainder", OPERATIONS, 5, operations_by_hand),
    Case("bits", LOGIC, 7, logic_by_hand),
    Case("a machine's cycle", MACHINE, 10, machine_by_hand),
    Case("calls of a subprogram", CALLS, 7, calls_by_hand),
)


def tables(bench: ArpBench) -> tuple[list[int], list[int], list[int], list[int]]:
    card = bench.card
    card.V[:] = [0] * len(card.V)
    card.V[2], card.V[3], card.V[5], card.V[6], card.V[9] = 1_500, 2_500, 7_000, 1_000, 0x1234
    return card.V, card.F, card.I, card.O


class Taken(NamedTuple):
    """Nanoseconds a statement."""

    by_hand: float
    compiled: float
    in_slices: float
    with_stops: float


def slice_size() -> int:
    """Instructions that a card with the costs and periods of its first start gives a program after a control loop."""
    budgets: list[int] = []

    def run(budget: int) -> int:
        budgets.append(budget)
        return 0

    period_ns, scheduler_ns = (
        PARAMETERS[GENERAL][number].default // SCALE * MS for number in (Par.CONTROL_PERIOD_MS, Par.SCHEDULER_PERIOD_MS)
    )
    Slices(Costs(), period_ns, scheduler_ns).give(run)
    return budgets[0]


def measure(case: Case, slice_: int) -> Taken:
    """The four take turns, and the fastest of each counts."""
    fast, sliced, watched = ArpBench(case.source), ArpBench(case.source), ArpBench(case.source)
    compiled = watched.program.compiled
    assert isinstance(compiled, Compiled)
    routine = compiled.program.routines[0]
    assert watched.program.break_at({routine.end_number})  # where none of them ever comes
    total = case.statements * ROUNDS
    taken: list[list[float]] = [[], [], [], []]
    for _ in range(REPEATS):
        numbers = tables(fast)
        start = time.perf_counter_ns()
        case.by_hand(*numbers, ROUNDS)
        taken[0].append((time.perf_counter_ns() - start) / total)
        for place, bench, size in ((1, fast, total), (2, sliced, slice_), (3, watched, total)):
            tables(bench)
            bench.program.start()
            start = time.perf_counter_ns()
            for _ in range(total // size):
                bench.program.run(size)
            taken[place].append((time.perf_counter_ns() - start) / (total // size * size))
    return Taken(*(min(each) for each in taken))


def run() -> Report:
    size = slice_size()
    report = Report(
        "The ARP's BASIC",
        f"This table shows nanoseconds per statement in short loops: {ROUNDS:,} rounds, best of {REPEATS}."
        f" In slices, a card gives the program {size} instructions after each control loop.",
        (
            "program",
            "CPython by hand, unchecked",
            "compiled",
            "ratio, at most 3",
            "in slices",
            "ratio",
            "breakpoints on",
            "ratio, at most 4",
        ),
    )
    ratios = []
    for case in CASES:
        progress(f"ARP BASIC: {case.name}")
        taken = measure(case, size)
        whole, slices, stops = (duration / taken.by_hand for duration in taken[1:])
        ratios.append((whole, slices, stops))
        report.add(case.name, taken.by_hand, taken.compiled, whole, taken.in_slices, slices, taken.with_stops, stops)
    whole, slices, stops = (statistics.geometric_mean(each) for each in zip(*ratios, strict=True))
    report.notes.append(
        f"geometric means of the ratios: {whole:.2f} compiled, {slices:.2f} in slices, {stops:.2f} with breakpoints on"
    )
    return report


if __name__ == "__main__":
    print(run().markdown())
