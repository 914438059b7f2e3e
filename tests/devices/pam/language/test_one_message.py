"""A slip of the pen has one message, which names the right word or the line that a missing end belongs to."""

import pytest
from pam_programs import HEADER, MACHINE, in_sequence, mistakes_of

from fieldrig_devices.pam.language.compiler import checked

FIRST = in_sequence("").splitlines().index("SEQUENCE SEQ_Test;") + 2
"""The line of the first statement."""


def only(text: str) -> str:
    """The one message about a text."""
    found = mistakes_of(text)
    assert len(found) == 1, [str(wrong) for wrong in found]
    return str(found[0])


@pytest.mark.parametrize(
    ("statement", "said"),
    [
        ("IF CWV_Count != 5 THEN IFV_Go <- set; END_IF", "got !=; expected <>"),
        ("CWV_Count := 5;", "got :=; expected <-"),
        ("AXI_Belt:TRAVEL_SPEED := 5;", "got :=; expected <-"),
        ("IF CWV_Count == 5 THEN IFV_Go <- set; END_IF", "got ==; expected ="),
        ("IFV_Go <- IFV_Go && SBI_Start;", "got &&; expected *"),
        ("IFV_Go <- IFV_Go AND SBI_Start;", "got AND; expected *"),
        ("IFV_Go <- NOT SBI_Start;", "got NOT; expected !"),
        ("IFV_Go <- TRUE;", "got TRUE; expected 1"),
        ("WAITTIME 5;", "got WAITTIME; expected WAIT_TIME"),
        ("waittime 5;", "got waittime; expected WAIT_TIME"),
        ("IF IFV_Go THEN IFV_Go <- set; ENDIF", "got ENDIF; expected END_IF"),
        ("LOOP IFV_Go <- set; ENDLOOP IFV_Go;", "got ENDLOOP; expected END_LOOP"),
        ("XEQSEQUENCE SEQ_Other;", "got XEQSEQUENCE; expected XEQ_SEQUENCE"),
        ("CONDITION IFV_Go TIME_OUT 5;", "got TIME_OUT; expected TIMEOUT"),
        ("AXI_Belt <- relativemove(5);", "got relativemove; expected relative_move"),
        ("IF IFV_Go THEN IFV_Go <- set; ELSIF SBI_Start THEN IFV_Go <- set; END_IF", "got ELSIF; expected ELSE IF"),
        ("IF CWV_Count ≠ 5 THEN IFV_Go <- set; END_IF", "got ≠; expected <>"),
        ("IF CWV_Count ≤ 5 THEN IFV_Go <- set; END_IF", "got ≤; expected <="),
        ("IF CWV_Count ≥ 5 THEN IFV_Go <- set; END_IF", "got ≥; expected >="),
        ("IF CWV_Count >< 5 THEN IFV_Go <- set; END_IF", "got ><; expected <>"),
        ("IF IFV_Go THAN IFV_Go <- set; END_IF", "got THAN; expected THEN"),
        ("IF IFV_Go Tehn IFV_Go <- set; END_IF", "got Tehn; expected THEN"),
        ("IF IFV_Go DO IFV_Go <- set; ELSE IFV_Go <- reset; END_IF", "got DO; expected THEN"),
        ("WAIT_TIME 5 ms;", "got ms; expected a number of milliseconds without a unit"),
        ("WAIT_TIME CWV_Count s;", "got s; expected a number of milliseconds without a unit"),
        ("CONDITION IFV_Go TIMEOUT 500 ms;", "got ms; expected a number of milliseconds without a unit"),
        ("CONDTION IFV_Go;", "Perhaps CONDITION is meant."),
        ("IF IFV_Go THEN IFV_Go <- set; END IF", "got END IF; expected END_IF"),
        ("LOOP IFV_Go <- set; END LOOP IFV_Go;", "got END LOOP; expected END_LOOP"),
        ("WAIT TIME 5;", "got WAIT TIME; expected WAIT_TIME"),
        ("xeq sequence SEQ_Other;", "got xeq sequence; expected XEQ_SEQUENCE"),
        ("WHILE IFV_Go;", "There is one loop: LOOP"),
        ("IFV_Go = set;", "got =; expected <-"),
        ("CWV_Count <- 0x1F;", "got 0x1F; expected #1F"),
        ("CWV_Count <- 16#1F;", "got 16#1F; expected #1F"),
        ("CWV_Count <- $1f;", "got $1f; expected #1f"),
        ("CRV_Size <- 1e-3;", "got 1e-3; expected a number without an exponent"),
        ("CRV_Size <- 2.5E3;", "got 2.5E3; expected a number without an exponent"),
        ("CWV_Count <- 7 DIV 2;", "got DIV; expected /"),
        ("IF CWV_Count<-5 THEN IFV_Go <- set; END_IF", "got <-; expected < -, with a blank between them"),
        ("CONDITION CRV_Size<-CWV_Count;", "got <-; expected < -"),
        ("WAIT 5;", "got WAIT; expected WAIT_TIME"),
        ("DELAY 2.5;", "got DELAY; expected WAIT_TIME"),
        ("AXI_Belt <- absolut_move(4);", "an AXIS has no function absolut_move; expected absolute_move"),
        ("LED_Run <- flash(1);", "an LED_OUTPUT has no function flash; expected blink"),
        ("CRV_Size <- sqrt(2);", "got sqrt; expected a value in front of ? sqrt"),
        ("CALL RTN_Show(1, 2);", "got (; expected WITH and the arguments"),
        ("AXI_Station[3] <- stop;", "an index is wrong; expected [i], [all]"),
        ("AXI_Station[n + 1] <- stop;", "an index is wrong; expected [i], [all]"),
        ("WAIT_TIME 5s;", "got 5s; expected 5000"),
        ("WAIT_TIME 2.5min;", "got 2.5min; expected 150000"),
        ("WAIT_TIME T#5s;", "got T#5s; expected 5000"),
        ("WAIT_TIME T#1m30s;", "got T#1m30s; expected a number of milliseconds without a unit"),
        ("CONDITION IFV_Go TIMEOUT 500ms;", "got 500ms; expected 500"),
        ("PAMDISPLAY <- warning(2, 'late', 0);", "got 'late'; expected \"late\""),
        ("CWV_Count++;", "A value is changed as in CWV_Count <- CWV_Count + 1."),
        ("CWV_Count -= 2;", "A value is changed as in CWV_Count <- CWV_Count - 1."),
        ("GOTO SEQ_Other;", "There are no jumps: a sequence goes on in another one by XEQ_SEQUENCE"),
        ("RETURN;", "There are no jumps"),
        ("CWV_Count <- CWV_Count++;", "A value is changed as in M <- M + 1."),
        ("--CWV_Count;", "A value is changed as in CWV_Count <- CWV_Count - 1."),
        ("CWV_Count ← 5;", "got ←; expected <-"),
        ("CWV_Count <– 5;", "got <–; expected <-"),
        ("CRV_Size <- CRV_Size − 1;", "got −; expected -"),
        ("IFV_Go <- set；", "got ；; expected ;"),
        ("PAMDISPLAY <- warning(2, “late”, 0);", 'got “late”; expected "late"'),
        ("IFV_Go <- IFV_Go | SBI_Start;", "got |; expected +"),
        ("IFV_Go <- ~SBI_Start;", "got ~; expected !"),
        ("CWV_Count <- 0b101;", "got 0b101; expected 5"),
        ("CWV_Count <- 2#1_01;", "got 2#1_01; expected 5"),
        ("CWV_Count <- 8#17;", "got 8#17; expected 15"),
        ("CWV_Count <- 1FH;", "got 1FH; expected #1F"),
        ("CWV_Count <- 1_000;", "got 1_000; expected 1000"),
        ("CRV_Size <- .5;", "got .5; expected 0.5"),
        ("CRV_Size <- 1,5;", "got 1,5; expected 1.5"),
        ("WAIT_TIME 2,5;", "got 2,5; expected 2.5"),
        ("(* a comment *) IFV_Go <- set;", "got (*; expected a comment, /* ... */"),
        ("IFV_Go <- set; }", "Statements are between words such as THEN and END_IF"),
        ("IFV_Go <- ON;", "got ON; expected set"),
        ("IFV_Go <- off;", "got off; expected reset"),
        ("IFV_Go.set;", "got .; expected <-"),
        ("AXI_Belt.absolute_move(5);", "got .; expected <-"),
        ("CONDITION AXI_Belt.ready;", "got .; expected ?"),
        ("CONDITION AXI_Belt ready;", "? is missing behind AXI_Belt"),
        ("AXI_Belt <- stop();", "got (); expected arguments, or no parentheses"),
        ("AXI_Belt <- absolute_move 5;", "( is missing behind absolute_move"),
        ("LOOP IFV_Go <- set; END_LOOP", "a condition is missing behind END_LOOP"),
        ("LOOP IFV_Go <- set; END_LOOP;", "a condition is missing behind END_LOOP"),
        ("CWV_Count <- CWV_Count + ;", "got ;; expected a value"),
        ("IFV_Go <- set; END_IF", "END_IF has no IF in front of it"),
        ("IFV_Go <- set; ELSE IFV_Go <- reset; END_IF", "ELSE has no IF in front of it"),
        ("IFV_Go <- set; END_LOOP IFV_Go;", "END_LOOP has no LOOP in front of it"),
        ("CASE CWV_Count OF 1: IFV_Go <- set; END_CASE", "A case is as in CASE CONDITION M = 1 XEQ_SEQUENCE"),
        ("RTN_Show(1, 2);", "A routine is called as in CALL RTN_Show WITH 1, 2;"),
        ("CALL RTN_Show WITH 1;", "RTN_Show is called with 1 argument; expected 2"),
        ("SBI_Start <- set;", "expected an object of the kind BINARY_OUTPUT"),
        ("CWV_Count <- max(1, 2);", "expected no call, as no object has max"),
    ],
)
def test_slips_in_statements(statement: str, said: str) -> None:
    assert said in only(in_sequence(statement))


@pytest.mark.parametrize(
    ("item", "said"),
    [
        ("NODE NOD_a; ADDRESS := 5; TYPE = ST1; END", "got :=; expected ="),
        ("NODE NOD_a; ADDRESS <- 5; TYPE = ST1; END", "got <-; expected ="),
        (
            "AMPLIFIER AMP_a; GAIN = 1; OFFSET = 0; GAINSLOPE = MAX; OFFSET_SLOPE = MAX; END",
            "got GAINSLOPE; expected GAIN_SLOPE",
        ),
        ("SINKE SNK_a; END", "Perhaps SINK is meant."),
        ("SEQUENCE SEQ_a; END_SEQUENCE", "A part that begins with SEQUENCE belongs in TASK."),
        ("NODE NOD_a; ADDRESS = 70; TYPE = ST1; END_NODE", "got END_NODE; expected END"),
        ("NODE NOD_a; ADDRESS = 70; TYPE = ST1; ENDNODE", "got ENDNODE; expected END"),
        ("SINK SNK_a; END_SINK", "got END_SINK; expected END"),
        ("TAKS TSK_a; SPECS CYCLES = 1; END_SPECS END_TASK", "Perhaps TASK is meant."),
        ("TASK TSK_a; SPECS CYCLES = 1; END SPECS END_TASK", "got END SPECS; expected END_SPECS"),
        ("/* a /* b */ c */ SINK SNK_a; END", "a comment is inside another one"),
        ("TASK TSK_a; SPECS CYCLES = 1; ENDSPECS END_TASK", "got ENDSPECS; expected END_SPECS"),
    ],
)
def test_slips_in_declarations(item: str, said: str) -> None:
    assert said in only(MACHINE + item)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "SINK SNK_a; END\n#define DEF_Place 70\nNODE NOD_a; ADDRESS = DEF_Palce; TYPE = ST1; END",
            "ADDRESS is DEF_Palce, which is not a number; expected a number\n  hint: Perhaps DEF_Place is meant.",
        ),
        (
            "#define DEF_Wait 70\n" + in_sequence("WAIT_TIME DEF_Wiat;").removeprefix(MACHINE),
            "Perhaps DEF_Wait is meant.",
        ),
    ],
)
def test_a_mistyped_name_of_a_definition(text: str, said: str) -> None:
    assert said in only(MACHINE + text)


def test_a_node_of_an_unknown_type_is_no_second_mistake_for_what_is_on_it() -> None:
    node = "NODE NOD_a; ADDRESS = 70; TYPE = ST2; END"
    sensor = "BINARY_INPUT SBI_a; NODE = NOD_a; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END"
    axis = "AXIS AXI_a; NODE = NOD_a; PULSES_PER_UNIT = 1.0; TRAVEL_SPEED = 1.0; ACCELERATION = 1.0; "
    axis += "INITIAL_POSITION = 0.0; POSITION_PERIOD = 9.0; END"
    assert "expected ST1 or SMART_IO" in only(f"{MACHINE}{node} {sensor} {axis}")


def test_a_long_chain_of_elsif_has_messages() -> None:
    assert mistakes_of(in_sequence("IF IFV_Go THEN " + "ELSIF IFV_Go THEN " * 3_000))


NESTED = """IF IFV_Go THEN
  LOOP
    IF SBI_Start THEN
      IFV_Go <- set;
    ELSE
      IFV_Go <- reset;
    END_IF
  END_LOOP IFV_Go;
  CASE
    CONDITION IFV_Go XEQ_SEQUENCE SEQ_Other;
  END_CASE
END_IF
IF IFV_Go THEN
  IF SBI_Start THEN
    IFV_Go <- set;
  END_IF
  IFV_Go <- reset;
END_IF"""


@pytest.mark.parametrize(
    ("missing", "word", "belongs"),
    [
        (6, "END_IF", 2),
        (7, "END_LOOP", 1),
        (10, "END_CASE", 8),
        (11, "END_IF", 0),
        (15, "END_IF", 13),
        (17, "END_IF", 12),
    ],
)
def test_a_missing_end_names_the_line_that_it_belongs_to(missing: int, word: str, belongs: int) -> None:
    lines = NESTED.splitlines()
    assert word in lines[missing]
    lines[missing] = ""
    found = only(in_sequence("\n".join(lines)))
    assert f"{word} is missing behind" in found
    assert f"in line {FIRST + belongs}." in found


PROGRAM = """APPLICATION
  NAME = a V1.00;
  BASIC_PAM_CYCLE = 3;
END
NODE NOD_a;
  ADDRESS = 1;
  TYPE = ST1;
END
AXIS AXI_a;
  NODE = NOD_a;
  PULSES_PER_UNIT = 1;
  TRAVEL_SPEED = 1;
  ACCELERATION = 1;
  INITIAL_POSITION = 0;
  POSITION_PERIOD = 1;
END
NODE NOD_b;
  ADDRESS = 2;
  TYPE = SMART_IO;
END
INTERNAL FLAG_VAR f;
INTERNAL FLAG_VAR g;
  NUMBER = 2;
END
VME DUALPORT
  SPECS
    DEFAULT_PERIOD = 5;
    MASTER_READY_TIMEOUT = NONE;
    MASTER_CONFIGURATION_TIMEOUT = NONE;
    MASTER_INACTIVITY_TIMEOUT = NONE;
  END_SPECS
  INPUT FLAG_VAR p;
END_DUALPORT
BOOLEAN BOL_a;
  EQUATION f;
END_BOOLEAN
ROUTINES RGR_a;
  ROUTINE RTN_a;
    f <- set;
  END_ROUTINE
  ROUTINE RTN_b;
    f <- set;
  END_ROUTINE
  POWERON
    f <- set;
  END_POWERON
END_ROUTINES
ACTIONS ACT_a;
  SPECS
    CYCLES = 1;
  END_SPECS
  ON_EVENT f ACTION
    f <- set;
  END_ACTION
  ON_STATE f ACTION
    f <- set;
  END_ACTION
END_ACTIONS
TASK TSK_a;
  SPECS
    CYCLES = 1;
  END_SPECS
  EVENTS
    ON_EVENT f XEQ_SEQUENCE SEQ_a;
  END_EVENTS
  SEQUENCE SEQ_a;
    f <- set;
  END_SEQUENCE
  SEQUENCE SEQ_b;
    f <- set;
  END_SEQUENCE
END_TASK
TASK TSK_b;
  SPECS
    CYCLES = 1;
  END_SPECS
END_TASK
SINK SNK_a;
END
"""
LINES = PROGRAM.splitlines()
ENDS = [number for number, line in enumerate(LINES) if line.strip().startswith("END")]


def opening(end: int) -> int:
    """The number of the line that an end belongs to: the last one before it with the same indentation."""
    width = len(LINES[end]) - len(LINES[end].lstrip())
    return max(n for n in range(end) if len(LINES[n]) - len(LINES[n].lstrip()) == width and "END" not in LINES[n])


def test_two_words_in_their_places_stay_two() -> None:
    assert (
        mistakes_of(f"{MACHINE}SINK SNK_a; END TASK TSK_a; END_TASK ACTIONS A; SPECS CYCLES = 1; END_SPECS END_ACTIONS")
        == []
    )


def test_the_program_is_right() -> None:
    assert mistakes_of(PROGRAM) == []


@pytest.mark.parametrize("end", ENDS, ids=[f"{LINES[end].strip()} of line {end + 1}" for end in ENDS])
def test_each_end_of_a_program_may_be_missing(end: int) -> None:
    text = "\n".join("" if number == end else line for number, line in enumerate(LINES))
    found = only(text)
    assert f"{LINES[end].strip()} is missing behind" in found
    assert f"It belongs to the {LINES[opening(end)].split()[0]} in line {opening(end) + 1}." in found


def test_the_file_of_what_is_open_is_named() -> None:
    from fieldrig_devices.pam.language.compiler import checked

    files = {"a.pam": "TASK TSK_a;\nSPECS CYCLES = 1; END_SPECS\n"}
    found = checked(f'{HEADER}#include "a.pam"\n', "main.pam", files.get)[1]
    assert "It belongs to the TASK in line 1 of a.pam." in str(found[0])


@pytest.mark.parametrize(
    "text",
    [
        in_sequence("AXI_Station[ALL] <- stop;"),
        in_sequence("IF (AXI_Station[All*] ? ready) THEN IFV_Go <- set; END_IF"),
        MACHINE.replace("APPLICATION", '#INCLUDE "ST1ERROR.SYS"\n#Define FAST 5\nAPPLICATION', 1),
        in_sequence("CWV_Count\n<- 5;"),
    ],
)
def test_keywords_in_other_cases_are_no_slips(text: str) -> None:
    assert mistakes_of(text) == []


def test_the_missing_end_of_a_trace_belongs_to_it() -> None:
    origin = "TIME_ORIGIN_SLOPE = POSITIVE; TIME_ORIGIN_COMPARE_MODE = IMMEDIATE; TIME_ORIGIN_REFERENCE = 1;"
    traces = "TRACE TRC_a; ROUTINE = NONE;\n  TRACE TRC_b; ROUTINE = NONE; END\nEND"
    said = only(f"{MACHINE}MULTI_COMPARATOR MUL_a; {origin} VALUE_PERIOD = 9;\n  {traces}")
    line = MACHINE.count("\n") + 2
    assert f"{line}:31: END is missing behind ;" in said
    assert f"It belongs to the TRACE in line {line}." in said


@pytest.mark.parametrize(
    ("comment", "notes"),
    [
        ("/* a\nCWV_Count <- 1; /* b */", ["the comment has another /* in it"]),
        ("/* a /* b */ /* c */ /* d /* e */", ["the comment has another /* in it"] * 2),
        ("/* a */ /* b */ // /* c", []),
        ("/** /* a", []),
        ("/* // */", []),
    ],
)
def test_a_comment_that_begins_in_another_one_is_worth_a_note(comment: str, notes: list[str]) -> None:
    """The text between them is silently no part of the program (manual lines 788 to 794)."""
    found = checked(in_sequence(comment), "a.pam")[1]
    assert [note.what for note in found] == notes
    assert all(note.is_note for note in found)


@pytest.mark.parametrize(
    ("statement", "fault"),
    [
        ("CWV_Count <- 5 / 0;", "02..FFF2"),
        ("CWV_Count <- 5 % 0;", "02..FFF2"),
        ("CRV_Size <- 2.0 / (1 - 1);", "02..FFF3"),
    ],
)
def test_a_division_by_zero_is_worth_a_note_with_its_fault(statement: str, fault: str) -> None:
    """It stops the program, but perhaps the statement is never reached (PAML-228)."""
    *_, note = checked(in_sequence(statement), "a.pam")[1]
    assert (note.what, note.is_note) == ("this divides by 0", True)
    assert fault in note.hint


@pytest.mark.parametrize("text", ["", "// nothing", "#define A 1\n"])
def test_the_message_about_an_empty_file_names_it(text: str) -> None:
    (found,) = checked(text, "empty.pam")[1]
    assert (found.file, found.line, found.column) == ("empty.pam", 1, 1)
    assert found.what == "the program does not begin with APPLICATION"
