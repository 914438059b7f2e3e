"""The task configuration (digest 1.4), and VAR_CONFIG."""

import pytest
from iec_check import checked, messages, program

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Located, Task, TaskKind

PROGRAMS = """
PROGRAM Belt ; END_PROGRAM
PROGRAM Lamp ; END_PROGRAM
VAR_GLOBAL start : BOOL; count : INT; END_VAR
"""


def configuration(inside: str) -> str:
    return f"CONFIGURATION C RESOURCE R ON PLC\n{inside}\nEND_RESOURCE END_CONFIGURATION"


def tasks(inside: str) -> dict[str, Task]:
    found, mistakes = checked(PROGRAMS, configuration(inside))
    assert not [mistake for mistake in mistakes if not mistake.is_note], mistakes
    return {task.name: task for task in found.tasks}


def test_the_three_kinds_of_tasks() -> None:
    found = tasks(
        "TASK Cyclic(INTERVAL := T#10ms, PRIORITY := 30); TASK Free(PRIORITY := 31);"
        "TASK Event(SINGLE := start, PRIORITY := 0);"
        "PROGRAM a WITH Cyclic : Belt; PROGRAM b WITH Free : Lamp; PROGRAM c WITH Event : Belt;"
    )
    assert [(task.kind, task.priority, task.interval_ms) for task in found.values()] == [
        (TaskKind.CYCLIC, 30, 10.0),
        (TaskKind.FREE, 31, 0.0),
        (TaskKind.EVENT, 0, 0.0),
    ]
    event = found["Event"].event
    assert event is not None
    assert event.name == "start"


@pytest.mark.manual("PD-060")
def test_a_task_runs_several_programs_in_their_order() -> None:
    found = tasks("TASK T(INTERVAL := T#10ms); PROGRAM a WITH T : Lamp; PROGRAM b WITH T : Belt;")
    assert [pou.name for pou in found["T"].programs] == ["Lamp", "Belt"]


@pytest.mark.manual("PD-033")
def test_a_task_configuration_that_names_no_program_is_an_error() -> None:
    assert messages(PROGRAMS, configuration("TASK T(INTERVAL := T#10ms);")) == [
        "2:1 the task T names no program; PROGRAM ... WITH T : ...; (PD-033)"
    ]


def test_a_task_beside_a_program_without_one_is_left_out_in_edition_3() -> None:
    """A project of Beremiz has one, if its program is not assigned to the task."""
    inside = "TASK T(INTERVAL := T#4ms); PROGRAM a : Lamp;"
    found, mistakes = checked(PROGRAMS, configuration(inside), dialect=EDITION_3)
    assert [(task.kind, [pou.name for pou in task.programs]) for task in found.tasks] == [(TaskKind.FREE, ["Lamp"])]
    assert [mistake.what for mistake in mistakes] == ["the task T names no program"]


def test_idle_tasks_of_twincat_are_left_out() -> None:
    inside = "TASK T(INTERVAL := T#4ms); TASK U(INTERVAL := T#9ms);"
    found, mistakes = checked(PROGRAMS, configuration(f"{inside} PROGRAM a WITH U : Lamp;"), dialect=CODESYS)
    assert [(task.name, [pou.name for pou in task.programs]) for task in found.tasks] == [("U", ["Lamp"])]
    assert [mistake.what for mistake in mistakes] == ["the task T names no program"]
    main = "PROGRAM Main ; END_PROGRAM"
    found, mistakes = checked(PROGRAMS + main, configuration(inside), dialect=CODESYS)
    assert [(task.interval_ms, [pou.name for pou in task.programs]) for task in found.tasks] == [(4.0, ["Main"])]
    assert mistakes[0].what == "the task T names no program, and runs Main"
    found, mistakes = checked(PROGRAMS + main, dialect=CODESYS)
    assert [pou.name for pou in found.tasks[0].programs] == ["Main"]


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        (
            "TASK T(INTERVAL := T#10ms, PRIORITY := 32); PROGRAM a WITH T : Belt;",
            "2:40 the priority 32; 0 (highest) to 31 (PD-061)",
        ),
        (
            "TASK T(INTERVAL := T#10ms, PRIORITY := -1); PROGRAM a WITH T : Belt;",
            "2:40 the priority -1; 0 (highest) to 31 (PD-061)",
        ),
        ("TASK T(INTERVAL := 10); PROGRAM a WITH T : Belt;", "2:20 the number 10 is no TIME; TIME"),
        (
            "TASK T(INTERVAL := T#0ms); PROGRAM a WITH T : Belt;",
            "2:20 the interval is 0; a TIME such as T#10ms, or no INTERVAL for a free-running task",
        ),
        (
            "TASK T(SINGLE := count); PROGRAM a WITH T : Belt;",
            "2:18 count starts an event task; a global BOOL behind SINGLE",
        ),
        ("TASK T(SINGLE := nix); PROGRAM a WITH T : Belt;", "2:18 nix is not declared; a global BOOL behind SINGLE"),
        ("TASK T(); TASK t(); PROGRAM a WITH T : Belt;", "2:11 the task t is declared twice; another name"),
        ("TASK T(); PROGRAM a WITH T : Belt; PROGRAM b WITH U : Lamp;", "2:36 there is no task U; the name of a TASK"),
        ("TASK T(); PROGRAM a WITH T : Bell;", "2:11 the program Bell is not declared; the name of a PROGRAM"),
        ("TASK T(); PROGRAM a WITH T : TON;", "2:11 TON is a FUNCTION_BLOCK; the name of a PROGRAM"),
    ],
)
def test_a_task_is_refused_with_one_message(inside: str, expected: str) -> None:
    assert messages(PROGRAMS, configuration(inside)) == [expected]


@pytest.mark.parametrize("dialect", [EPAS_4, CODESYS])
def test_two_names_of_a_program_are_one_program_and_that_is_noted(dialect: Dialect) -> None:
    """In edition 3 each is an instance with its own variables (`test_program_instances`)."""
    program = "PROGRAM Count VAR n : INT; END_VAR n := n + 1; END_PROGRAM"
    inside = "TASK T(INTERVAL := T#1ms); TASK S(INTERVAL := T#2ms); PROGRAM a WITH T : Count; PROGRAM b WITH S : Count;"
    found, mistakes = checked(program, configuration(inside), dialect=dialect)
    assert [pou.name for task in found.tasks for pou in task.programs] == ["Count", "Count"]
    (note,) = mistakes
    assert (note.is_note, note.line, note.what) == (True, 2, "a and b are one program Count, with the same variables")


@pytest.mark.parametrize(
    ("program", "second"),
    [
        ("PROGRAM Count VAR n : INT; END_VAR n := n + 1; END_PROGRAM", "a"),
        ("PROGRAM Count VAR n : INT; END_VAR n := n + 1; END_PROGRAM", "A"),
        ("PROGRAM Count ; END_PROGRAM", "b"),
    ],
)
def test_a_program_under_one_name_or_without_variables_has_no_note(program: str, second: str) -> None:
    inside = f"TASK T(INTERVAL := T#1ms); PROGRAM a WITH T : Count; PROGRAM {second} WITH T : Count;"
    _, mistakes = checked(program, configuration(inside), dialect=EDITION_3)
    assert mistakes == []


@pytest.mark.manual("PD-061")
@pytest.mark.parametrize("priority", [0, 31])
def test_priorities_are_0_to_31(priority: int) -> None:
    found = tasks(f"TASK T(INTERVAL := T#1ms, PRIORITY := {priority}); PROGRAM a WITH T : Belt;")
    assert found["T"].priority == priority


@pytest.mark.manual("PD-061")
@pytest.mark.parametrize("priority", [-1, 32])
def test_other_priorities_are_refused(priority: int) -> None:
    inside = f"TASK T(INTERVAL := T#1ms, PRIORITY := {priority}); PROGRAM a WITH T : Belt;"
    assert messages(PROGRAMS, configuration(inside)) == [f"2:39 the priority {priority}; 0 (highest) to 31 (PD-061)"]


@pytest.mark.parametrize("dialect", [EDITION_3, CODESYS])
def test_the_other_dialects_have_a_uint_for_the_priority_and_the_free_program_below_all(dialect: Dialect) -> None:
    inside = "TASK T(INTERVAL := T#1ms, PRIORITY := 90); PROGRAM a WITH T : Belt; PROGRAM b : Lamp;"
    found, mistakes = checked(PROGRAMS, configuration(inside), dialect=dialect)
    assert [(task.name, task.priority) for task in found.tasks] == [("T", 90), ("b", 90)]
    assert mistakes == []
    (message,) = messages(PROGRAMS, configuration(inside.replace("90", "65536")), dialect=dialect)
    assert "0 (highest) to 65535" in message


@pytest.mark.manual("PD-081")
def test_a_task_without_a_priority_has_the_one_that_the_dialog_of_epas_4_proposes() -> None:
    """Manual 3705: "leave the priority at 31"."""
    assert tasks("TASK T(INTERVAL := T#100ms); PROGRAM a WITH T : Belt;")["T"].priority == 31


def test_without_a_configuration_plc_prg_runs_every_10_ms() -> None:
    found, mistakes = checked(PROGRAMS, program("x : INT;"))
    assert [(task.name, task.interval_ms) for task in found.tasks] == [("PLC_PRG", 10.0)]
    assert [mistake.is_note for mistake in mistakes] == [True]


def test_without_a_configuration_the_only_program_runs() -> None:
    found, _ = checked("PROGRAM Only ; END_PROGRAM")
    assert [pou.name for pou in found.tasks[0].programs] == ["Only"]


def test_several_programs_without_a_configuration_are_a_mistake() -> None:
    assert messages(PROGRAMS) == ["2:1 no task runs any of the programs Belt, Lamp; a task configuration"]


def test_global_variables_of_the_configuration_are_known_everywhere() -> None:
    text = (
        "CONFIGURATION C VAR_GLOBAL g : INT; END_VAR RESOURCE R ON PLC "
        "TASK T(); PROGRAM a WITH T : PLC_PRG; END_RESOURCE END_CONFIGURATION"
    )
    assert messages(program("x : INT;", "x := g;"), text) == []


# ---- addresses


@pytest.mark.manual("PD-363")
@pytest.mark.manual("PD-364")
@pytest.mark.parametrize(
    ("address", "kind", "place"),
    [
        ("%MD48", "DWORD", ("M", 192, -1)),
        ("%MX5.0", "BOOL", ("M", 10, 0)),  # the first bit of word 5
        ("%MX5.15", "BOOL", ("M", 11, 7)),
        ("%QX75", "BOOL", ("Q", 9, 3)),
        ("%Q75", "BOOL", ("Q", 9, 3)),
        ("%IW215", "INT", ("I", 430, -1)),
        ("%QB7", "BYTE", ("Q", 7, -1)),
        ("%MD3", "REAL", ("M", 12, -1)),
    ],
)
def test_addresses_are_indexed_by_the_unit_of_access(address: str, kind: str, place: tuple[str, int, int]) -> None:
    found, mistakes = checked(program(f"x AT {address} : {kind};"))
    assert not [mistake for mistake in mistakes if not mistake.is_note]
    location = found.pous["plc_prg"].variables["x"].location
    assert isinstance(location, Located)
    assert (location.area, location.byte, location.bit) == place


@pytest.mark.manual("PD-363")
@pytest.mark.parametrize(
    ("declaration", "expected"),
    [
        ("x AT %MW3 : DINT;", "the address %MW3 does not have the size of DINT; %MD"),
        ("x AT %MX3.0 : INT;", "the address %MX3.0 does not have the size of INT; %MW"),
        ("x AT %MB3 : BOOL;", "the address %MB3 does not have the size of BOOL; %MX"),
        (
            "x AT %MX5.16 : BOOL;",
            (
                "the address %MX5.16 does not exist in the control configuration; "
                "%MX with a word and a bit of 0 to 15, or one number"
            ),
        ),
        (
            "x AT %IW2.5.7.1 : WORD;",
            (
                "the address %IW2.5.7.1 does not exist in the control configuration; "
                "%MX with a word and a bit of 0 to 15, or one number"
            ),
        ),
        (
            "x AT %MB3 : STRING;",
            "a variable of type STRING cannot have an address; an elementary type or an array of them",
        ),
    ],
)
def test_addresses_that_are_refused(declaration: str, expected: str) -> None:
    assert [message.partition(" ")[2] for message in messages(program(declaration))] == [expected]


@pytest.mark.manual("PD-363")
def test_addresses_may_overlap_and_arrays_have_addresses_too() -> None:
    text = (
        "a AT %MB12 : BYTE; b AT %MW6 : WORD; c AT %MD3 : DWORD; d AT %MX6.0 : BOOL; e AT %MB12 : ARRAY[0..3] OF BYTE;"
    )
    assert messages(program(text, "e[2] := a; d := TRUE;")) == []


def test_inputs_are_only_read() -> None:
    assert messages(program("x AT %IX3.0 : BOOL;", "x := TRUE; %IB3 := 4;")) == [
        "3:1 x is an input; a variable that may be written here",
        "3:12 %IB3 is an input; a variable that may be written here",
    ]


def test_var_config_completes_an_address() -> None:
    text = program("x AT %Q* : BOOL;", "x := TRUE;")
    config = "VAR_CONFIG PLC_PRG.x AT %QX3.1 : BOOL; END_VAR"
    assert [message.partition(" ")[2] for message in messages(text)] == [
        "the address %Q* of x is incomplete; its address in VAR_CONFIG"
    ]
    found, mistakes = checked(text, config)
    assert not [mistake for mistake in mistakes if not mistake.is_note], mistakes
    assert found.pous["plc_prg"].variables["x"].location == Located("Q", 6, 1, Elementary.BOOL)


def test_var_config_names_variables_with_an_incomplete_address() -> None:
    text = program("x AT %Q* : BOOL; y : BOOL;")
    config = "VAR_CONFIG PLC_PRG.x AT %QX3.1 : BOOL; PLC_PRG.y AT %QX3.2 : BOOL; PLC_PRG.z AT %QX3.3 : BOOL; END_VAR"
    assert [message.partition(" ")[2] for message in messages(text, config)] == [
        "PLC_PRG.y has no incomplete address; y AT %I* : BOOL in its POU",
        "there is no variable PLC_PRG.z; a path PROGRAM.instance.variable",
    ]


def test_in_edition_3_var_config_gives_an_address_to_a_variable_without_one() -> None:
    config = "VAR_CONFIG PLC_PRG.y AT %QX3.1 : BOOL; END_VAR"
    found, mistakes = checked(program("y : BOOL;"), config, dialect=EDITION_3)
    assert not [mistake for mistake in mistakes if not mistake.is_note], mistakes
    assert found.pous["plc_prg"].variables["y"].location == Located("Q", 6, 1, Elementary.BOOL)
    assert "PLC_PRG.y has no incomplete address" in "\n".join(messages(program("y : BOOL;"), config))


@pytest.mark.parametrize(("second", "links"), [("%QX3.1", []), ("%QX3.2", ["PLC_PRG.a.x", "PLC_PRG.b.x"])])
def test_instances_of_a_function_block_have_the_same_address_or_different_ones(second: str, links: list[str]) -> None:
    block = "FUNCTION_BLOCK B VAR x AT %Q* : BOOL; END_VAR x := TRUE; END_FUNCTION_BLOCK"
    config = f"VAR_CONFIG PLC_PRG.a.x AT %QX3.1 : BOOL; PLC_PRG.b.x AT {second} : BOOL; END_VAR"
    found, mistakes = checked(block, program("a, b : B;"), config)
    assert not [mistake for mistake in mistakes if not mistake.is_note], mistakes
    assert [link.path for link in found.links] == links
    assert (found.pous["b"].variables["x"].location is None) is bool(links)
