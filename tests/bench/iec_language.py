"""IEC 61131-3 programs against CPython doing the same by hand, unchecked: nanoseconds of CPU time a statement.

By hand means what a Python programmer would write: variables that last are attributes of an object, arrays are lists,
function blocks are objects with a method, `while` and `if` for the same loops and choices; with no range check, no wrap
of integers and no means to stop it.  Integer quotients are truncated toward zero by hand wherever a sign is not known,
and REAL is rounded to single precision after each operation in the same way, by a store to an `array` of floats.

A program runs in one piece, and in slices of its processor time: 250 us, which is what a task gets at equal priority,
and shorter ones.
"""

import statistics
import time
from array import array
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from iec_program import IecBench
from report import Report, progress
from turns import REPEATS, shown, take_turns

from fieldrig.clock import US
from fieldrig_devices.iec.tasks.task import TICK_NS, WorkState

ROUNDS = 20_000
SHORT_NS = 50 * US
"""A slice that the begin of another task has shortened."""
BUDGETS_NS = (10**12, TICK_NS, SHORT_NS)
"""In one piece, and in slices of a task."""
LINES, COMPILED = 60_000, 3
F = array("f", [0.0, 0.0])

INTEGER = """
PROGRAM PLC_PRG
VAR i, rounds, count, sum, last, limit : DINT; small : INT; END_VAR
limit := 900000;
FOR i := 1 TO rounds DO
  count := count + 1;
  sum := sum + count * 3 - last;
  last := sum / 7;
  small := small + 5;
  IF count >= limit THEN
    count := 0;
  END_IF;
END_FOR
END_PROGRAM
"""

ARRAYS = """
PROGRAM PLC_PRG
VAR i, rounds : DINT; n : INT; a : ARRAY[0..99] OF INT; b : ARRAY[0..99] OF REAL; most : INT; END_VAR
FOR i := 1 TO rounds DO
  n := n + 1;
  IF n > 99 THEN
    n := 0;
  END_IF;
  a[n] := a[99 - n] + n;
  b[n] := b[n] + 1.5;
  IF a[n] > most THEN
    most := a[n];
  END_IF;
END_FOR
END_PROGRAM
"""

REAL = """
PROGRAM PLC_PRG
VAR i, rounds : DINT; x, y, k, target, speed : REAL; END_VAR
k := 0.125; target := 250.0;
FOR i := 1 TO rounds DO
  speed := (target - x) * k;
  x := x + speed * 0.01;
  y := y * 0.9 + x * 0.1;
  IF x > 240.0 THEN
    x := 0.0;
  END_IF;
END_FOR
END_PROGRAM
"""

BOOLEAN = """
PROGRAM PLC_PRG
VAR i, rounds : DINT; start, stop, motor, alarm, lamp : BOOL; word1, word2 : WORD; END_VAR
FOR i := 1 TO rounds DO
  motor := (start OR motor) AND NOT stop;
  alarm := motor AND (word1 > 100) OR stop;
  lamp := alarm XOR motor;
  IF lamp THEN
    start := NOT start;
  ELSE
    stop := NOT stop;
  END_IF;
  word2 := word1 AND 16#0F0F OR 16#1000;
  word1 := word2 + 1;
END_FOR
END_PROGRAM
"""

STRING = """
PROGRAM PLC_PRG
VAR i, rounds : DINT; name, text : STRING; length, found : INT; same : BOOL; END_VAR
name := 'axis';
FOR i := 1 TO rounds DO
  text := CONCAT(name, ' is ready');
  length := LEN(text);
  same := text = 'axis is ready';
  text := LEFT(text, 6);
  found := FIND(text, 'is');
END_FOR
END_PROGRAM
"""

BLOCKS = """
FUNCTION_BLOCK RAMP
VAR_INPUT target, step : DINT; END_VAR
VAR_OUTPUT value : DINT; done : BOOL; END_VAR
IF value < target THEN
  value := value + step;
  done := FALSE;
ELSE
  value := 0;
  done := TRUE;
END_IF;
END_FUNCTION_BLOCK

FUNCTION Half : DINT
VAR_INPUT x : DINT; END_VAR
Half := x / 2;
END_FUNCTION

PROGRAM PLC_PRG
VAR i, rounds, total, halves : DINT; first, second : RAMP; END_VAR
FOR i := 1 TO rounds DO
  first(target := 1000, step := 3);
  second(target := first.value, step := 1);
  total := first.value - second.value;
  halves := Half(total);
END_FOR
END_PROGRAM
"""


class Plc:
    """The variables of a program."""

    def __init__(self) -> None:
        self.count = self.sum = self.last = self.small = self.n = self.most = 0
        self.limit = 900_000
        self.a, self.b = [0] * 100, [0.0] * 100
        self.x = self.y = self.speed = 0.0
        self.k, self.target = 0.125, 250.0
        self.start = self.stop = self.motor = self.alarm = self.lamp = False
        self.word1 = self.word2 = 0
        self.name, self.text, self.length, self.found, self.same = "axis", "", 0, 0, False
        self.total = self.halves = 0
        self.first, self.second = Ramp(), Ramp()


class Ramp:
    def __init__(self) -> None:
        self.target = self.step = self.value = 0
        self.done = False

    def run(self, target: int, step: int) -> None:
        self.target, self.step = target, step
        if self.value < self.target:
            self.value += self.step
            self.done = False
        else:
            self.value = 0
            self.done = True


def half(x: int) -> int:
    return x // 2 if x >= 0 else -(-x // 2)


def integer_by_hand(plc: Plc, rounds: int) -> None:
    for _ in range(rounds):
        plc.count += 1
        plc.sum = plc.sum + plc.count * 3 - plc.last
        plc.last = plc.sum // 7 if plc.sum >= 0 else -(-plc.sum // 7)
        plc.small += 5
        if plc.count >= plc.limit:
            plc.count = 0


def arrays_by_hand(plc: Plc, rounds: int) -> None:
    for _ in range(rounds):
        plc.n += 1
        if plc.n > 99:
            plc.n = 0
        plc.a[plc.n] = plc.a[99 - plc.n] + plc.n
        F[0] = plc.b[plc.n] + 1.5
        plc.b[plc.n] = F[0]
        if plc.a[plc.n] > plc.most:
            plc.most = plc.a[plc.n]


def real_by_hand(plc: Plc, rounds: int) -> None:
    for _ in range(rounds):
        F[0] = plc.target - plc.x
        F[0] = F[0] * plc.k
        plc.speed = F[0]
        F[0] = plc.speed * 0.01
        F[0] = plc.x + F[0]
        plc.x = F[0]
        F[0] = plc.y * 0.9
        F[1] = plc.x * 0.1
        F[0] = F[0] + F[1]
        plc.y = F[0]
        if plc.x > 240.0:
            plc.x = 0.0


def boolean_by_hand(plc: Plc, rounds: int) -> None:
    for _ in range(rounds):
        plc.motor = (plc.start or plc.motor) and not plc.stop
        plc.alarm = (plc.motor and plc.word1 > 100) or plc.stop
        plc.lamp = plc.alarm != plc.motor
        if plc.lamp:
            plc.start = not plc.start
        else:
            plc.stop = not plc.stop
        plc.word2 = plc.word1 & 0x0F0F | 0x1000
        plc.word1 = plc.word2 + 1


def string_by_hand(plc: Plc, rounds: int) -> None:
    for _ in range(rounds):
        plc.text = plc.name + " is ready"
        plc.length = len(plc.text)
        plc.same = plc.text == "axis is ready"
        plc.text = plc.text[:6]
        plc.found = plc.text.find("is") + 1


def blocks_by_hand(plc: Plc, rounds: int) -> None:
    for _ in range(rounds):
        plc.first.run(1000, 3)
        plc.second.run(plc.first.value, 1)
        plc.total = plc.first.value - plc.second.value
        plc.halves = half(plc.total)


@dataclass(frozen=True)
class Case:
    name: str
    source: str
    statements: int
    """Number of statements in one round, the loop included."""
    by_hand: Callable[[Plc, int], None]


CASES = (
    Case("integers", INTEGER, 6, integer_by_hand),
    Case("arrays", ARRAYS, 8, arrays_by_hand),
    Case("real numbers", REAL, 5, real_by_hand),
    Case("booleans", BOOLEAN, 8, boolean_by_hand),
    Case("strings", STRING, 6, string_by_hand),
    Case("calls of blocks and functions", BLOCKS, 11, blocks_by_hand),
)


def run_all(bench: IecBench, budget: int) -> None:
    thread = bench.thread
    thread.start()
    while thread.state is WorkState.READY:
        thread.run(budget)
    assert thread.state is WorkState.ENDED


def measure(case: Case) -> tuple[list[float], list[list[float]]]:
    """Return nanoseconds a statement by hand, and of the program for each of `BUDGETS_NS`; they take turns."""
    bench = IecBench(case.source)
    bench["rounds"] = ROUNDS
    programs = [partial(run_all, bench, budget_ns) for budget_ns in BUDGETS_NS]
    by_hand, *taken = take_turns(case.statements * ROUNDS, lambda: case.by_hand(Plc(), ROUNDS), programs)
    return by_hand, taken


def generated(lines: int) -> str:
    """Return a project with about this number of lines: function blocks of all kinds of statements."""
    parts = [
        f"""FUNCTION_BLOCK Station{number}
VAR_INPUT enable, sensor : BOOL; target : REAL; END_VAR
VAR_OUTPUT state : INT; position : REAL; done : BOOL; END_VAR
VAR delay : TON; counts : ARRAY[0..9] OF DINT; i : INT; END_VAR
delay(IN := enable AND NOT sensor, PT := T#50ms);
CASE state OF
  0: IF enable THEN state := 10; END_IF;
  10: position := position + (target - position) * 0.25;
      IF ABS(target - position) < 0.5 OR delay.Q THEN
        state := 20;
      END_IF;
  20: FOR i := 0 TO 9 DO
        counts[i] := counts[i] + i;
      END_FOR
      done := TRUE;
ELSE
  state := 0;
END_CASE
END_FUNCTION_BLOCK
"""
        for number in range(lines // 20)
    ]
    calls = "\n".join(f"s{n}(enable := TRUE, target := {n}.5);" for n in range(lines // 20))
    names = "\n".join(f"s{n} : Station{n};" for n in range(lines // 20))
    return "".join(parts) + f"PROGRAM PLC_PRG\nVAR\n{names}\nEND_VAR\n{calls}\nEND_PROGRAM\n"


def lines_a_second() -> list[float]:
    """Return what each of `COMPILED` compilations of a project reaches."""
    text = generated(LINES)
    found = []
    for _ in range(COMPILED):
        start = time.process_time()
        IecBench(text)
        found.append(text.count("\n") / (time.process_time() - start))
    return found


def run() -> Report:
    tick, short = f"{TICK_NS // US} us", f"{SHORT_NS // US} us"
    report = Report(
        "IEC 61131-3 programs",
        "This table shows nanoseconds of CPU time per statement in short loops, and their ratio to CPython doing the"
        f" same by hand, unchecked: {ROUNDS:,} rounds, mean and standard deviation of {REPEATS} turns. In slices, the"
        f" task gives way after each {tick} or {short} of its processor time.",
        (
            "program",
            "by hand",
            "in one piece",
            "ratio, at most 3",
            f"ratio in slices of {tick}, at most 3",
            f"ratio in slices of {short}, at most 3",
        ),
    )
    means = []
    for case in CASES:
        progress(f"IEC 61131-3: {case.name}")
        by_hand, taken = measure(case)
        ratios = [[one / other for one, other in zip(each, by_hand, strict=True)] for each in taken]
        means.append([statistics.mean(each) for each in ratios])
        report.add(case.name, shown(by_hand, ".0f"), shown(taken[0], ".0f"), *(shown(each, ".2f") for each in ratios))
    whole, sliced, shortest = (statistics.geometric_mean(each) for each in zip(*means, strict=True))
    report.notes.append(
        f"geometric means of the ratios, at most 2: {whole:.2f} in one piece, {sliced:.2f} in slices of {tick},"
        f" {shortest:.2f} in slices of {short}"
    )
    worst = max(max(each) for each in means)
    report.notes.append(f"worst ratio, at most 3: {worst:.2f}")
    progress("IEC 61131-3: compiling")
    report.notes.append(
        f"compiled lines a second of CPU time, at least 5,000: {shown(lines_a_second(), ',.0f')} in {COMPILED}"
        f" compilations of a project of {LINES:,} lines"
    )
    return report


if __name__ == "__main__":
    print(run().markdown())
