"""The cost of coverage: the same program with and without marks, turn by turn in one process."""

import statistics
import sys
import time
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from pam_bench import OBJECTS  # noqa: E402
from report import COMPARED, Report, progress  # noqa: E402  found beside this file

from fieldrig import MS, ProgramBench, program  # noqa: E402
from fieldrig.coverage.collecting import collecting  # noqa: E402

MOST = 1.2
"""The most that a run with coverage may take of one without."""
ROUNDS = 25
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
    ("IEC 61131-3: loops of a controller", "loops.st", LOOPS, 1_000, WAYS),
    ("PAM: loops of a sequence", "loops.pam", PAM, 600, WAYS[:1]),
    ("BASIC of a card, whole card", "loops.I01", BASIC, 300, WAYS[:1]),
)
"""Each with the virtual time of one turn, in milliseconds."""


def loaded(file: Path, ways: Sequence[tuple[str, bool]]) -> list[ProgramBench]:
    """Load a program without marks, and with marks in each of these ways."""
    contexts: list[AbstractContextManager[object]] = [nullcontext()]
    contexts += [collecting(is_detailed=detailed) for _, detailed in ways]
    benches = []
    for context in contexts:
        with context:
            benches.append(program(file))
            _begin(benches[-1])
    return benches


def _begin(bench: ProgramBench) -> None:
    if not hasattr(bench, "_rig"):  # a card runs by itself
        bench.start()
    bench.advance(20 * MS)
    if bench.__class__.__module__.endswith("pam.bench"):
        bench["SBI_b"] = True
    bench.advance(100 * MS)


def times(benches: list[ProgramBench], duration_ms: int) -> list[list[float]]:
    """Return the processor times of turns of each, in seconds; each round begins with another one."""
    found: list[list[float]] = [[] for _ in benches]
    for turn in range(ROUNDS):
        for place in range(len(benches)):
            number = (turn + place) % len(benches)
            begin_s = time.process_time()
            benches[number].advance(duration_ms * MS)
            found[number].append(time.process_time() - begin_s)
    return found


def run() -> Report:
    report = Report(
        "Cost of coverage",
        "This table shows what a run with marks takes of one without, as the mean of its rounds and their standard"
        " deviation; a round has one turn of each. At most 1.2 is wanted.",
        COMPARED,
    )
    for name, file_name, text, duration_ms, ways in PROGRAMS:
        progress(name)
        with TemporaryDirectory() as folder:
            file = Path(folder) / file_name
            file.write_text(text, encoding="utf-8")
            plain, *others = times(loaded(file, ways), duration_ms)
        for (way, _), with_marks in zip(ways, others, strict=True):
            ratios = [marked / without for marked, without in zip(with_marks, plain, strict=True)]
            mean = statistics.mean(ratios)
            shown = f"{mean:.3f} ± {statistics.stdev(ratios):.3f}"
            report.add(f"{name}, {way}", shown, f"{MOST}", mean / MOST)
    return report


if __name__ == "__main__":
    print(run().markdown())
