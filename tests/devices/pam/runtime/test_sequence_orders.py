"""Random orders of events against a simple model of the states of sequences."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_bench import OBJECTS, PamBench

from fieldrig_devices.pam.runtime.compiler import compile_application
from fieldrig_devices.pam.runtime.memory_objects import MemoryObjects
from fieldrig_devices.pam.runtime.runtime import Runtime

PROGRAM = """
TASK TSK_a; SPECS CYCLES = 1; END_SPECS
EVENTS ON_EVENT SBI_a XEQ_SEQUENCE SEQ_a; ON_EVENT SBI_b XEQ_SEQUENCE SEQ_b; END_EVENTS
SEQUENCE SEQ_a;
  n <- n * 10 + 1;
  EXCEPTION SBI_c TIMEOUT 6 SEQUENCE SEQ_c;
  CONDITION SBI_b TIMEOUT 4;
  IF TIMEOUT THEN n <- n * 10 + 2; ELSE n <- n * 10 + 3; END_IF
  WAIT_TIME 3;
  n <- n * 10 + 4;
END_SEQUENCE
SEQUENCE SEQ_b; n <- n * 10 + 5; WAIT_TIME 2; n <- n * 10 + 6; END_SEQUENCE
SEQUENCE SEQ_c; n <- n * 10 + 7; IF TIMEOUT THEN n <- n * 10 + 8; END_IF END_SEQUENCE
END_TASK
""".replace("n <- n * 10 + ", "n <- n % 1000000 * 10 + ")
COMPILED = compile_application(OBJECTS + PROGRAM, "a.pam")
LEVELS = st.tuples(st.booleans(), st.booleans(), st.booleans())


class Model:
    """The three sequences as a table of steps; one cycle after the other, as the manual describes them."""

    def __init__(self) -> None:
        self.levels = (False, False, False)
        self.n, self.cycle = 0, 0
        self.step = ""
        """Empty while the task is dead, or what the sequence waits for: condition, rest, b."""
        self.due = 0
        self.late: int | None = None
        """Cycle of the time-out of the exception; None while none is armed."""
        self.is_armed = self.is_latched = False

    def add(self, digit: int) -> None:
        self.n = self.n % 1_000_000 * 10 + digit

    def run(self, levels: tuple[bool, bool, bool]) -> None:
        self.cycle += 1
        (was_a, was_b, was_c), (a, b, c), self.levels = self.levels, levels, levels
        if self.late is not None and c and not was_c:
            self.is_latched = True
        if not self.step:
            if a and not was_a:
                self._start_a(b=b, c=c)
                return
            if b and not was_b:
                self.add(5)
                self.step, self.due = "b", self.cycle + 2
                return
        if self.late is not None and (self.is_latched or self.cycle >= self.late):
            self._handle(is_timeout=not self.is_latched)
        elif self.step == "condition" and (b or self.cycle >= self.due):
            self.add(3 if b else 2)
            self.step, self.due = "rest", self.cycle + 3
        elif self.step in ("rest", "b") and self.cycle >= self.due:
            self.add(4 if self.step == "rest" else 6)
            self.step, self.late = "", None

    def _start_a(self, *, b: bool, c: bool) -> None:
        self.add(1)
        self.late, self.is_latched = self.cycle + 6, False
        if c:
            self._handle(is_timeout=False)
        elif b:
            self.add(3)
            self.step, self.due = "rest", self.cycle + 3
        else:
            self.step, self.due = "condition", self.cycle + 4

    def _handle(self, *, is_timeout: bool) -> None:
        self.add(7)
        if is_timeout:
            self.add(8)
        self.step, self.late, self.is_latched = "", None, False


@pytest.mark.long
@settings(max_examples=100)
@given(st.lists(LEVELS, max_size=40))
def test_sequences_follow_the_model(history: list[tuple[bool, bool, bool]]) -> None:
    bench = object.__new__(PamBench)
    bench.program, bench.messages = COMPILED, []
    bench.runtime = Runtime(COMPILED)
    bench.objects = MemoryObjects(COMPILED, bench.runtime)
    bench.runtime.start(bench.objects)
    model = Model()
    bench.run()
    model.run((False, False, False))
    for levels in history:
        bench["SBI_a"], bench["SBI_b"], bench["SBI_c"] = levels
        bench.run()
        model.run(levels)
        assert bench["n"] == model.n
        assert bench.runtime.tasks[0].is_alive == bool(model.step)
