"""The cost of coverage: the same program with and without marks, turn by turn in one process."""

import statistics
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from pam_bench import OBJECTS  # noqa: E402
from report import COMPARED, Report, progress  # noqa: E402  found beside this file

from fieldrig import MS, ProgramBench, S, program  # noqa: E402
from fieldrig.config.rig_file import load  # noqa: E402
from fieldrig.coverage.collecting import collecting  # noqa: E402
from fieldrig.virtual.rig import Rig  # noqa: E402

CONFIGS = HERE.parents[1] / "configs"

MOST = 1.2
"""The most that a run with coverage may take of one without."""
ROUNDS, TURNS = 12, 6
"""Rounds, and turns of each run within a round.  A turn takes some 70 ms of processor time: a round is long enough to
be measured, and all runs meet the same load of the host."""
LOOPS = """\
FUNCTION_BLOCK Pid
VAR_INPUT sp, pv, kp, ki, kd, d : REAL; hold : BOOL; END_VAR
VAR_OUTPUT out : REAL; sat : BOOL; END_VAR
VAR e, last, sum : REAL; state : INT; END_VAR
e := sp - pv;
IF NOT hold AND d > 0.0 THEN sum := sum + e * ki * d; END_IF
out := kp * e + sum + kd * (e - last) / d;
IF out > 100.0 THEN out := 100.0; sat := TRUE; ELSIF out < 0.0 THEN out := 0.0; sat := TRUE; ELSE sat := FALSE; END_IF
last := e;
CASE state OF
0: IF sat AND NOT hold THEN state := 1; END_IF
1: IF NOT sat OR hold THEN state := 2; END_IF
2: state := 0;
ELSE state := 0;
END_CASE
END_FUNCTION_BLOCK
PROGRAM Main
VAR p : ARRAY[0..9] OF Pid; i, n : INT; x : REAL; END_VAR
FOR i := 0 TO 9 DO
  p[i](sp := 50.0, pv := x, kp := 1.0, ki := 0.1, kd := 0.01, d := 0.01);
  x := x + p[i].out * 0.001;
  IF x > 60.0 THEN x := 0.0; END_IF
END_FOR
WHILE n < 10 DO n := n + 1; END_WHILE
n := 0;
END_PROGRAM
"""
PAM = (
    OBJECTS
    + """
TASK TSK_a; SPECS CYCLES = 1; END_SPECS EVENTS ON_EVENT SBI_b XEQ_SEQUENCE SEQ_a; END_EVENTS
SEQUENCE SEQ_a;
  LOOP
    w <- 0;
    LOOP
      w <- w + 1;
      IF w > 5 THEN x <- x + w * 0.5; ELSE y <- y - 1; END_IF
      IF (w > 3) * (x > y) THEN n <- n + 1; END_IF
      IF n > 1000 THEN n <- 0; END_IF
    END_LOOP w > 20;
    WAIT_TIME 3;
  END_LOOP f;
END_SEQUENCE
END_TASK
"""
)
BASIC = """\
BEG MAIN
AGAIN: V1 += 1
IF V1 > 100, V1 == 0
IF V1 < 50, GOTO LOW
V2 == V1 * 2
GOTO BOTH
LOW: V2 == V1 * 3
BOTH: IF V2 > V3, V3 == V2
CALL SUB
GOTO AGAIN
END
BEG SUB
V4 += V2
IF V4 > 10000, V4 == 0
END
"""
WAYS = (("coverage", False), ("with conditions", True))
PROGRAMS = (
    ("IEC 61131-3: loops of a controller", "loops.st", LOOPS, 20_000, WAYS),
    ("PAM: loops of a sequence", "loops.pam", PAM, 15_000, WAYS),
    ("BASIC of a card, whole card", "loops.I01", BASIC, 8_000, WAYS[:1]),
)
"""Each with the virtual time of one turn, in milliseconds.  An IF of BASIC has one condition: its branches show it."""
RIG = ("IEC 61131-3: the whole feeder, hot and feeding", CONFIGS / "feeder.yaml", 5_000, WAYS)

Advance = Callable[[int], object]
"""Lets nanoseconds of virtual time pass."""


def loaded(make: Callable[[], Advance], ways: Sequence[tuple[str, bool]]) -> list[Advance]:
    """Make a run without marks, and one with marks in each of these ways."""
    contexts: list[AbstractContextManager[object]] = [nullcontext()]
    contexts += [collecting(is_detailed=detailed) for _, detailed in ways]
    runs = []
    for context in contexts:
        with context:
            runs.append(make())
    return runs


def program_of(file: Path) -> Advance:
    bench = program(file)
    _begin(bench)
    return bench.advance


def feeder_of(file: Path) -> Advance:
    rig = Rig(load(file, ["time=virtual"]))
    rig.run_until(60 * S)
    rig.set("feeder", "g_bStart", True)
    rig.run_for(100 * MS)
    return rig.run_for


def _begin(bench: ProgramBench) -> None:
    if not hasattr(bench, "_rig"):  # a card runs by itself
        bench.start()
    bench.advance(20 * MS)
    if bench.__class__.__module__.endswith("pam.bench"):
        bench["SBI_b"] = True
    bench.advance(100 * MS)


def times(runs: Sequence[Advance], duration_ms: int) -> list[list[float]]:
    """Return the processor times of each run in each round, in seconds; each turn begins with another run."""
    found: list[list[float]] = [[] for _ in runs]
    for _ in range(ROUNDS):
        sums = [0.0 for _ in runs]
        for turn in range(TURNS):
            for place in range(len(runs)):
                number = (turn + place) % len(runs)
                begin_s = time.process_time()
                runs[number](duration_ms * MS)
                sums[number] += time.process_time() - begin_s
        for times_s, sum_s in zip(found, sums, strict=True):
            times_s.append(sum_s)
    return found


def run() -> Report:
    report = Report(
        "Cost of coverage",
        "This table shows what a run with marks takes of one without in processor time, as the mean of its rounds and"
        f" their standard deviation; a round has {TURNS} turns of each. At most {MOST} is wanted.",
        COMPARED,
    )
    for name, file_name, text, duration_ms, ways in PROGRAMS:
        progress(name)
        with TemporaryDirectory() as folder:
            file = Path(folder) / file_name
            file.write_text(text, encoding="utf-8")
            runs = loaded(partial(program_of, file), ways)
        _add(report, name, times(runs, duration_ms), ways)
    name, file, duration_ms, ways = RIG
    progress(name)
    _add(report, name, times(loaded(partial(feeder_of, file), ways), duration_ms), ways)
    return report


def _add(report: Report, name: str, taken: list[list[float]], ways: Sequence[tuple[str, bool]]) -> None:
    plain, *others = taken
    for (way, _), with_marks in zip(ways, others, strict=True):
        ratios = [marked / without for marked, without in zip(with_marks, plain, strict=True)]
        mean = statistics.mean(ratios)
        report.add(f"{name}, {way}", f"{mean:.3f} ± {statistics.stdev(ratios):.3f}", f"{MOST}", mean / MOST)


if __name__ == "__main__":
    print(run().markdown())
