"""Sequential Function Charts: the rules of manual 1709 to 1842, cycle by cycle."""

import pytest
from iec_check import checked, messages
from iec_program import IecBench, program

CYCLE_MS = 10


def run(bench: IecBench, name: str, cycles: int) -> list[object]:
    """Return a variable after each of several cycles."""
    found: list[object] = []
    for _ in range(cycles):
        bench.cycle()
        bench.host.ms += CYCLE_MS
        found.append(bench[name])
    return found


SIMPLE = program(
    "log : STRING; go : BOOL;",
    """
INITIAL_STEP First:
    ENTRY log := CONCAT(log, 'a'); END_ENTRY
    ACTIVE log := CONCAT(log, 'b'); END_ACTIVE
    EXIT log := CONCAT(log, 'c'); END_EXIT
END_STEP
STEP Second:
    ENTRY log := CONCAT(log, 'd'); END_ENTRY
    ACTIVE LD go
        NOT
        ST go
        RET
    END_ACTIVE
END_STEP
TRANSITION FROM First TO Second := go; END_TRANSITION
TRANSITION FROM Second TO First := NOT First.x; END_TRANSITION
""",
)


def test_a_simple_step_runs_its_entry_action_once_its_active_action_each_cycle_and_its_exit_action_once() -> None:
    bench = IecBench(SIMPLE)
    assert run(bench, "log", 2) == ["ab", "abb"]
    bench["go"] = True
    assert run(bench, "log", 3) == ["abbbc", "abbbcd", "abbbcdab"]


def test_a_new_step_is_executed_in_the_next_cycle() -> None:
    bench = IecBench(SIMPLE)
    bench["go"] = True
    bench.cycle()
    assert (bench["First.x"], bench["Second.x"], bench["log"]) == (False, True, "abc")


QUALIFIERS = """
INITIAL_STEP Wait: END_STEP
STEP Work: out({use}); END_STEP
STEP Done: END_STEP
STEP Clear: out(R); END_STEP
TRANSITION FROM Wait TO Work := TRUE; END_TRANSITION
TRANSITION FROM Work TO Done := leave; END_TRANSITION
TRANSITION FROM Done TO Clear := reset; END_TRANSITION
"""

# The cycles 1 to 12 in which the action runs, if Work is active in the cycles 1 to 6, or 1 to 2, Clear from cycle
# 10 on.  A cycle is 10 ms long and the times are 30 ms (manual 1803 to 1819, table 4-13).
TABLE = [
    ("N", range(1, 7), range(1, 3)),
    ("S", range(1, 10), range(1, 10)),
    ("L, T#30ms", range(1, 4), range(1, 3)),
    ("D, T#30ms", range(4, 7), range(0)),
    ("P", range(1, 2), range(1, 2)),
    ("P1", range(1, 2), range(1, 2)),
    ("P0", range(7, 8), range(3, 4)),
    ("SD, T#30ms", range(4, 10), range(4, 10)),
    ("DS, T#30ms", range(4, 10), range(0)),
    ("SL, T#30ms", range(1, 4), range(1, 4)),
    ("R", range(0), range(0)),
]


@pytest.mark.manual("PD-204")
@pytest.mark.parametrize(("use", "expected", "expected_if_short"), TABLE)
@pytest.mark.parametrize("is_action", [False, True])
@pytest.mark.parametrize("is_short", [False, True])
def test_a_qualifier_decides_when_an_action_runs(
    use: str, expected: range, expected_if_short: range, is_action: bool, is_short: bool
) -> None:
    if is_action:
        chart = QUALIFIERS + "ACTION out: count := count + 1; END_ACTION"
        bench = IecBench(program("count : INT; leave : BOOL; reset : BOOL;", chart.format(use=use)))
    else:
        bench = IecBench(program("out : BOOL; leave : BOOL; reset : BOOL;", QUALIFIERS.format(use=use)))
    run(bench, "leave", 1)  # cycle 0, in which Wait is active
    found = set()
    for cycle in range(1, 13):
        bench["leave"] = cycle >= (2 if is_short else 6)
        bench["reset"] = cycle >= 9
        before = bench["count"] if is_action else 0
        value = run(bench, "count" if is_action else "out", 1)[0]
        if value != before:
            found.add(cycle)
    assert found == set(expected_if_short if is_short else expected)


def test_a_step_shows_its_time_from_its_first_cycle_on() -> None:
    chart = """
INITIAL_STEP Wait: END_STEP
STEP Work: END_STEP
TRANSITION FROM Wait TO Work := TRUE; END_TRANSITION
TRANSITION FROM Work TO Wait := Work.t >= T#20ms; END_TRANSITION
"""
    bench = IecBench(program("", chart))
    assert run(bench, "Work.t", 4) == [0, 0, 10, 20]
    assert bench["Wait.x"] is True


def test_the_first_alternative_branch_whose_condition_holds_is_taken() -> None:
    chart = """
INITIAL_STEP Wait: END_STEP
STEP Left: END_STEP
STEP Middle: END_STEP
STEP Right: END_STEP
TRANSITION FROM Wait TO Left := a; END_TRANSITION
TRANSITION FROM Wait TO Middle := TRUE; END_TRANSITION
TRANSITION (PRIORITY := {priority}) FROM Wait TO Right := TRUE; END_TRANSITION
"""
    for a, priority, expected in [(True, 1, "Left"), (False, 1, "Middle")]:
        bench = IecBench(program("a : BOOL;", chart.format(priority=priority)))
        bench["a"] = a
        bench.cycle()
        assert [name for name in ("Wait", "Left", "Middle", "Right") if bench[f"{name}.x"]] == [expected]


def test_a_lower_number_is_a_higher_priority() -> None:
    chart = """
INITIAL_STEP Wait: END_STEP
STEP Left: END_STEP
STEP Right: END_STEP
TRANSITION (PRIORITY := 2) FROM Wait TO Left := TRUE; END_TRANSITION
TRANSITION (PRIORITY := 1) FROM Wait TO Right := TRUE; END_TRANSITION
"""
    bench = IecBench(program("", chart))
    bench.cycle()
    assert (bench["Left.x"], bench["Right.x"]) == (False, True)


SIMULTANEOUS = """
INITIAL_STEP Start: END_STEP
STEP A1: END_STEP
STEP A2: END_STEP
STEP B1: END_STEP
STEP End: END_STEP
TRANSITION FROM Start TO (A1, B1) := TRUE; END_TRANSITION
TRANSITION FROM A1 TO A2 := a; END_TRANSITION
TRANSITION FROM (A2, B1) TO End := join; END_TRANSITION
TRANSITION FROM End TO Start := TRUE; END_TRANSITION
"""


def test_simultaneous_branches_begin_and_end_together() -> None:
    bench = IecBench(program("a : BOOL; join : BOOL := TRUE;", SIMULTANEOUS))

    def active() -> list[str]:
        bench.cycle()
        return [name for name in ("Start", "A1", "A2", "B1", "End") if bench[f"{name}.x"]]

    assert active() == ["A1", "B1"]
    assert active() == ["A1", "B1"]  # A2 is not active, so that B1 waits
    bench["a"] = True
    assert active() == ["A2", "B1"]
    bench["join"] = False
    assert active() == ["A2", "B1"]
    bench["join"] = True
    assert active() == ["End"]
    assert active() == ["Start"]


def test_a_condition_behind_an_inactive_step_is_not_evaluated() -> None:
    chart = """
INITIAL_STEP Wait: END_STEP
STEP Work: END_STEP
TRANSITION FROM Wait TO Work := go; END_TRANSITION
TRANSITION FROM Work TO Wait := 1 / zero = 1; END_TRANSITION
"""
    bench = IecBench(program("go : BOOL; zero : INT;", chart))
    bench.cycle(3)
    assert bench.thread.fault is None
    bench["go"] = True
    bench.cycle(2)
    assert bench.thread.fault is not None


def test_a_step_may_follow_itself() -> None:
    chart = """
INITIAL_STEP Only: ENTRY count := count + 1; END_ENTRY END_STEP
TRANSITION FROM Only TO Only := again; END_TRANSITION
"""
    bench = IecBench(program("count : INT; again : BOOL;", chart))
    bench.cycle(3)
    assert bench["count"] == 1
    bench["again"] = True
    assert run(bench, "count", 3) == [1, 2, 3]


def test_a_step_that_follows_itself_ends_and_begins_again() -> None:
    """IEC 61131-3, 6.7.5: a transition deactivates the steps before it, and then activates those behind it."""
    chart = """
INITIAL_STEP Only: starts(P1); ends(P0); runs(N); late(D, T#15ms); END_STEP
TRANSITION FROM Only TO Only := again; END_TRANSITION
ACTION starts: log := CONCAT(log, '1'); END_ACTION
ACTION ends: log := CONCAT(log, '0'); END_ACTION
"""
    bench = IecBench(program("log : STRING; again, runs, late : BOOL;", chart))
    assert run(bench, "log", 2) == ["1", "1"]
    bench["again"] = True
    assert run(bench, "late", 1) == [True]
    assert run(bench, "log", 2) == ["110", "11010"]
    assert (bench["runs"], bench["late"], bench["Only.t"]) == (True, False, 0)
    bench["again"] = False
    assert run(bench, "log", 3) == ["1101010"] * 3


def test_a_step_that_one_transition_leaves_and_another_enters_ends_and_begins_again() -> None:
    chart = """
INITIAL_STEP First: END_STEP
STEP Left: END_STEP
STEP Right: starts(P1); ends(P0); END_STEP
STEP Last: END_STEP
TRANSITION FROM First TO (Left, Right) := TRUE; END_TRANSITION
TRANSITION FROM Left TO Right := go; END_TRANSITION
TRANSITION FROM Right TO Last := go; END_TRANSITION
ACTION starts: log := CONCAT(log, '1'); END_ACTION
ACTION ends: log := CONCAT(log, '0'); END_ACTION
"""
    bench = IecBench(program("log : STRING; go : BOOL;", chart))
    assert run(bench, "log", 3) == ["", "1", "1"]
    bench["go"] = True
    assert run(bench, "log", 3) == ["1", "110", "1100"]


def test_a_block_has_its_chart_in_each_instance() -> None:
    block = """
FUNCTION_BLOCK Door
VAR_INPUT move : BOOL; END_VAR
VAR_OUTPUT isOpen : BOOL; END_VAR
INITIAL_STEP Closed: END_STEP
STEP Open: isOpen(N); END_STEP
TRANSITION FROM Closed TO Open := move; END_TRANSITION
TRANSITION FROM Open TO Closed := NOT move; END_TRANSITION
END_FUNCTION_BLOCK
"""
    bench = IecBench(block + program("a : Door; b : Door;", "a(move := TRUE); b();"))
    bench.cycle(2)
    assert (bench["a.isOpen"], bench["b.isOpen"]) == (True, False)
    assert (bench["a.Open.x"], bench["b.Open.x"]) == (True, False)


def test_an_action_may_be_a_chart_again() -> None:
    chart = """
INITIAL_STEP Outer: inner(N); END_STEP
ACTION inner:
    INITIAL_STEP One: ACTIVE n := n + 1; END_ACTIVE END_STEP
    STEP Two: ACTIVE n := n + 100; END_ACTIVE END_STEP
    TRANSITION FROM One TO Two := TRUE; END_TRANSITION
    TRANSITION FROM Two TO One := TRUE; END_TRANSITION
END_ACTION
"""
    assert run(IecBench(program("n : INT;", chart)), "n", 3) == [1, 101, 102]


def test_a_condition_may_be_in_il() -> None:
    chart = """
INITIAL_STEP Wait: END_STEP
STEP Work: END_STEP
TRANSITION FROM Wait TO Work :
    LD level
    GT 3
    ANDN stop
END_TRANSITION
"""
    bench = IecBench(program("level : INT := 3; stop : BOOL;", chart))
    bench.cycle()
    bench["level"] = 4
    assert bench["Work.x"] is False
    bench.cycle()
    assert bench["Work.x"] is True


# A chart, and what is said about it as `line:column what; expected`.
REFUSED = [
    ("STEP A: END_STEP", ["3:1 the chart has no initial step; INITIAL_STEP name:"]),
    (
        "INITIAL_STEP A: END_STEP INITIAL_STEP B: END_STEP TRANSITION FROM A TO B := TRUE; END_TRANSITION",
        ["3:26 B is a second initial step, beside A; one initial step"],
    ),
    (
        "INITIAL_STEP A: END_STEP TRANSITION FROM A TO Nowhere := TRUE; END_TRANSITION",
        ["3:26 there is no step Nowhere; a step of this chart"],
    ),
    (
        "INITIAL_STEP A: END_STEP STEP a: END_STEP TRANSITION FROM A TO A := TRUE; END_TRANSITION",
        ["3:26 step a exists already in line 3; another name"],
    ),
    ("INITIAL_STEP x: END_STEP", ["3:1 step x has the name of a variable; another name"]),
    ("INITIAL_STEP A: run(N); END_STEP", ["3:17 there is no action run; ACTION run: ... END_ACTION"]),
    ("INITIAL_STEP A: x(N); END_STEP", ["3:17 x is neither an action nor a BOOL variable; an action of this POU"]),
    (
        "INITIAL_STEP A: END_STEP TRANSITION FROM A TO A := x; END_TRANSITION",
        ["3:52 x is an INT; BOOL"],
    ),
]


@pytest.mark.parametrize(("chart", "expected"), REFUSED)
def test_a_chart_that_cannot_run_is_refused(chart: str, expected: list[str]) -> None:
    assert messages(f"PROGRAM PLC_PRG VAR x : INT; END_VAR\n\n{chart}\nEND_PROGRAM") == expected


def test_a_step_that_nothing_leads_to_is_noted() -> None:
    text = program("", "INITIAL_STEP A: END_STEP\nSTEP B: END_STEP\nTRANSITION FROM B TO A := TRUE; END_TRANSITION")
    notes = [mistake.what for mistake in checked(text)[1] if mistake.is_note]
    assert "step B never becomes active" in notes


@pytest.mark.manual("PD-354")
def test_a_function_cannot_be_written_in_sfc() -> None:
    assert messages("FUNCTION f : INT\n\nINITIAL_STEP A: END_STEP\nEND_FUNCTION") == [
        "3:1 a FUNCTION cannot be written in SFC; ST or IL"
    ]


INDICATED = program(
    "a, b, shown : BOOL;",
    """
INITIAL_STEP First:
    a(N, shown);
    b(L, T#15ms, shown);
END_STEP
""",
)


def test_indicator_variables_of_an_action_change_nothing() -> None:
    bench = IecBench(INDICATED)
    assert run(bench, "b", 3) == [True, True, False]
    assert (bench["a"], bench["shown"]) == (True, False)
    assert [message.partition(" ")[2] for message in messages(INDICATED.replace("shown : BOOL", "other : BOOL"))] == [
        "shown is not declared; an indicator variable that is declared"
    ]
