"""Tests of programs: how many in a second, for a block of 20 lines and for a rig with four drives."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from report import COMPARED, Report, progress  # noqa: E402  found beside this file

from fieldrig import MS, S, program  # noqa: E402
from fieldrig_devices.iec.dialect import EPAS_4  # noqa: E402
from fieldrig_devices.iec.testing.blocks import BlockSource  # noqa: E402
from fieldrig_devices.iec.testing.case import Limits, Verdict  # noqa: E402

CONFIGS = HERE.parents[1] / "configs"
BLOCK = """FUNCTION_BLOCK Motor
VAR_INPUT
    start, stop, fault : BOOL;
    longest : TIME := T#10s;
END_VAR
VAR_OUTPUT
    run, alarm : BOOL;
    starts : INT;
END_VAR
VAR
    edge : R_TRIG;
    clock : TON;
END_VAR
edge(CLK := start);
clock(IN := run, PT := longest);
IF edge.Q AND NOT alarm THEN run := TRUE; starts := starts + 1; END_IF;
IF fault THEN alarm := TRUE; END_IF;
IF stop OR alarm OR clock.Q THEN run := FALSE; END_IF;
END_FUNCTION_BLOCK
"""
TEST = """TEST 'number {}'
VAR m : Motor; END_VAR
m(start := TRUE); m(); ASSERT_TRUE(m.run);
ADVANCE_TIME(T#10s); m(start := FALSE); ASSERT_FALSE(m.run); ASSERT_EQ(m.starts, 1);
END_TEST
"""
IN_RIG = """TEST 'number {}'
RIG '{}' AFTER T#2s;
VAR
    panel AT 'panel/6200:01' : UINT;
    belt AT 'belt/speed' : LREAL;
END_VAR
panel := 1; ADVANCE_TIME(T#20ms); ASSERT_NEAR(belt, 0.0, 0.1);
END_TEST
"""
BLOCKS, RIGS, LIMITS = 2_000, 100, Limits(60.0)


@contextmanager
def written(**files: str) -> Iterator[Path]:
    with TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / f"{name}.st").write_text(text, encoding="utf-8")
        yield Path(folder)


def per_second(file: Path) -> float:
    """Return how many of the tests of a file run in a second, from the end of the first to that of the last."""
    source = BlockSource(file, EPAS_4)
    cases = source.cases()
    outcomes = source.run(cases, LIMITS)
    assert next(outcomes).verdict is Verdict.PASSED
    begin_s = time.perf_counter()
    assert all(outcome.verdict is Verdict.PASSED for outcome in outcomes)
    return (len(cases) - 1) / (time.perf_counter() - begin_s)


def in_python(file: Path) -> float:
    plc = program(file)
    begin_s = time.perf_counter()
    for _ in range(BLOCKS):
        plc.reset()
        motor = plc.block("Motor")
        assert motor(start=True)().run
        plc.advance(10 * S)
        assert not motor(start=False).run
        plc.advance(1 * MS)
        assert motor.starts == 1
    return BLOCKS / (time.perf_counter() - begin_s)


def run() -> Report:
    report = Report(
        "Tests of programs",
        "This table shows how many tests run in a second, each from a fresh state: a block with a timer and an edge, in"
        " test blocks and in Python, and the conveyor with its controller and four drives, each test in a branch.",
        COMPARED,
    )
    progress("tests of a block")
    with written(motor=BLOCK, motor_test="".join(TEST.format(number) for number in range(BLOCKS))) as folder:
        blocks = per_second(folder / "motor_test.st")
        python = in_python(folder / "motor.st")
    report.add("block of 20 lines, TEST blocks", f"{blocks:.0f} a second", "2000", 2000 / blocks)
    report.add("block of 20 lines, in Python", f"{python:.0f} a second", "2000", 2000 / python)
    progress("tests of a rig")
    rig = CONFIGS / "conveyor.yaml"
    with written(rig_test="".join(IN_RIG.format(number, rig) for number in range(RIGS))) as folder:
        rigs = per_second(folder / "rig_test.st")
    report.add("conveyor with four drives", f"{rigs:.0f} a second", "50", 50 / rigs)
    return report


if __name__ == "__main__":
    print(run().markdown())
