"""The checker: each rule with a program that breaks it, and programs of the manual's kinds that are right."""

import re

import pytest
from pam_programs import HEADER, MACHINE, in_sequence, mistakes_of

from fieldrig_devices.pam.language.compiler import checked


def said(text: str) -> str:
    return "\n".join(map(str, mistakes_of(text)))


def test_the_machine_is_right() -> None:
    assert checked(MACHINE, "x")[1] == []


RIGHT = [
    "AXI_Belt:TRAVEL_SPEED <- 2 * CRV_Size;",
    "AXI_Station[all]:ACCELERATION <- 5;",
    "CRV_Size <- AXI_Belt:TRAVEL_SPEED + 1;",
    "AXS_All <- power_on; CONDITION AXS_All ? ready TIMEOUT 5000;",
    "AXI_Belt <- relative_move(-10.5);",
    "IFV_Go <- set; IFV_Each[all] <- reset; SBO_Lamp <- invert;",
    "SBO_Lamp <- IFV_Each[all+] * !SBI_Start;",
    "IFV_Go <- (AXI_Station[i] ? speed >= 1)[all*];",
    "IFV_Go <- 0; IF IFV_Go = 1 THEN LED_Run <- blink; ELSE LED_Run <- no_blink; END_IF",
    'D7S_Digit <- display("P"); D7S_Digit <- display(CWV_Count / 1000, 1);',
    "CRV_Size <- CRV_Size ? sqrt; CWV_Count <- CRV_Size;",
    "CNV_Belt << CAM_Feed << AMP_Gear << TMP_Master; CONDITION CNV_Belt ? ready; CNV_Belt <- disactivate;",
    "CNV_Sink << AMP_Gear << TMP_Master; CNV_Belt << CAM_Feed << AMP_Gear << TMP_Master;",
    "CNV_Belt << DIS_Slow << TMP_Master;",
    "COR_Mark <- start_correction; COR_Mark <- start_correction(3.5); COR_Mark <- trigger(180);",
    "CMP_Full:ROUTINE <- RTN_Show WITH CRV_Size, 3; CMP_Full:THROUGH_ZERO_REFERENCE <- 10;",
    "CAM_Feed:PROFILE <- PRO_Feed; AMP_Gear:GAIN_SLOPE <- MAX; ZEP_Belt:FINE_MOVE <- NONE;",
    "CALL RTN_Show WITH CRV_Size / 10, CWV_Count;",
    "EXCEPTION SBI_Start TIMEOUT 1000 ENTRY out; EXCEPTION IFV_Go TIMEOUT ABORT_SEQUENCE; EXCEPTION_ENTRY out;",
    "EXCEPTION SBI_Start XEQ_TASK TSK_Test SEQUENCE SEQ_Other WAIT; REMOVE_EXCEPTION;",
    "CASE CONDITION SBI_Start XEQ_SEQUENCE SEQ_Other; TIMEOUT 500 XEQ_SEQUENCE SEQ_Test; END_CASE",
    "XEQ_TASK TSK_Test SEQUENCE SEQ_Other ABORT;",
    'PAMDISPLAY <- message(12, "started", CRV_Size); PamDisplay <- CRV_Size;',
    "CRV_Size <- ENC_Belt; CRV_Size <- ENC_Belt ? speed; ZEP_Belt <- start;",
    "CONDITION AXI_Belt ? error_code(4) + NOD_Desk ? error;",
]


@pytest.mark.parametrize("statements", RIGHT)
def test_right_statements(statements: str) -> None:
    assert said(in_sequence(statements)) == ""


@pytest.mark.parametrize("statements", RIGHT)
def test_right_statements_stay_right_if_names_are_the_same_in_any_case(statements: str) -> None:
    upper = re.sub(r"\[\w+[+*]?\]", lambda index: index[0].lower(), statements.upper())
    for text in (statements, upper):
        assert checked(in_sequence(text), "x", ignores_case=True)[1] == []


@pytest.mark.parametrize(
    ("text", "minds", "ignores"),
    [
        ("axi_belt <- stop;", "axi_belt is not declared here", ""),
        ("pamdisplay <- 1.5;", "pamdisplay is not declared here", ""),
        ("EXCEPTION IFV_Go ENTRY Out; EXCEPTION_ENTRY out;", "there is no entry Out", ""),
        ("END_SEQUENCE SEQUENCE seq_test;", "", "TSK_Test has the sequence SEQ_Test already"),
    ],
)
def test_names_in_another_case(text: str, minds: str, ignores: str) -> None:
    for ignores_case, expected in ((False, minds), (True, ignores)):
        found = "\n".join(map(str, checked(in_sequence(text), "x", ignores_case=ignores_case)[1]))
        assert expected in found
        assert bool(expected) is bool(found)


@pytest.mark.manual("PAML-245")
def test_the_present_item_in_a_multiple_task() -> None:
    statements = "AXI_Station[i] <- run(1); IFV_Each[i] <- SBI_Mark[i] + SBI_Start; XEQ_SEQUENCE SEQ_Other[i];"
    assert said(in_sequence(statements, specs="NODES_GROUP = NGR_Stations;", index="[i]")) == ""
    assert "[i] is used where there is no present item" in said(in_sequence("AXI_Station[i] <- run(1);"))


@pytest.mark.manual("PAML-590")
@pytest.mark.parametrize(
    ("domain", "expected"),
    [
        ("VALUE_PERIOD = 360;", ""),
        ("", "a PHASER is not complete; expected VALUE_PERIOD = ..."),
        ("VALUE_RANGE = 0 1;", "got VALUE_RANGE; expected a parameter of PHASER"),
    ],
)
def test_a_phaser_is_for_periodic_systems(domain: str, expected: str) -> None:
    phaser = f"PHASER PHA_a; PHASE = 0; PHASE_SLOPE = MAX; STANDBY_VALUE = 0; {domain} END"
    found = said(MACHINE + phaser)
    assert found.partition("pam:")[2].partition(": ")[2].startswith(expected) if expected else found == ""


ONE = """NODES_GROUP NGR_One; NUMBER = 1; END
NODE NOD_One; NODES_GROUP = NGR_One; ADDRESS = 9; TYPE = SMART_IO; END
BINARY_INPUT SBI_One; NODE = NOD_One; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 10; DEBOUNCE = 2; END
INTERNAL FLAG_VAR IFV_One; NUMBER = 1; END
"""


@pytest.mark.manual("PAML-006", "PAML-224")
@pytest.mark.parametrize(
    ("statements", "specs", "index"),
    [
        ("IFV_One <- SBI_One;", "", ""),  # manual line 2666: NUMBER = 1 is single
        ("IFV_One <- SBI_One;", "NUMBER = 1;", ""),
        ("IFV_One[i] <- SBI_One[i];", "NUMBER = 1;", "[i]"),
        ("IFV_One[all] <- SBI_One[all+];", "", ""),
    ],
)
def test_one_item_needs_no_index(statements: str, specs: str, index: str) -> None:
    text = in_sequence(statements, specs=specs, index=index)
    assert said(text.replace("TASK TSK_Test", f"{ONE}TASK TSK_Test")) == ""
    assert "[i] is used where" in said(in_sequence("IFV_One[i] <- set;").replace("TASK TSK", f"{ONE}TASK TSK"))


WRONG = [
    ("AXI_Blt <- stop;", "AXI_Blt is not declared here; expected an object\n  hint: Perhaps AXI_Belt is meant."),
    ("AXI_Belt <- start;", "an AXIS has no function start; expected absolute_move, "),
    ("AXI_Belt <- 5;", "an AXIS takes no value"),
    ("AXI_Belt <- run;", "run has 0 arguments; expected 1 of them"),
    ("CRV_Size <- AXI_Belt;", "an AXIS has no value of its own; expected an inquiry"),
    ("CRV_Size <- AXI_Belt ? stop;", "stop is an order: write AXI_Belt <- stop."),
    ("IFV_Go <- AXI_Belt ? temperature;", "an AXIS does not know the inquiry temperature; expected error"),
    ("IFV_Go <- !AXI_Belt ? ready;", "Write !(object ? ready)."),
    ("CRV_Size <- IFV_Go;", "this is a flag; expected a number"),
    ("IFV_Go <- 2;", "this is an integer; expected a flag"),
    ("IFV_Go <- IFV_Go * CRV_Size > 5;", "put them in parentheses"),
    ("IFV_Go <- IFV_Each;", "IFV_Each has several items; expected an index"),
    ("IFV_Go <- IFV_Each[all];", "[all] has no value; expected [all+] or [all*]"),
    ("IFV_Go <- IFV_Go[i];", "IFV_Go has one item only"),
    ("AXI_Belt:NODE <- 5;", "NODE of AXIS cannot be changed by a program"),
    ("CRV_Size <- AXI_Belt:PULSES_PER_UNIT;", "PULSES_PER_UNIT of an AXIS cannot be read by a program"),
    ("AXI_Belt:COLOUR <- 5;", "an AXIS has no parameter COLOUR"),
    ("CALL RTN_Show WITH 5;", "RTN_Show is called with 1 argument; expected 2 of them"),
    ("CALL AXI_Belt;", "AXI_Belt is an AXIS; expected a routine"),
    ("XEQ_SEQUENCE SEQ_None;", "TSK_Test has no sequence SEQ_None; expected SEQ_Test or SEQ_Other"),
    ("XEQ_SEQUENCE SEQ_Other[i];", "the index of SEQ_Other does not fit its task"),
    ("XEQ_TASK TSK_None SEQUENCE SEQ_Test;", "there is no task TSK_None"),
    ("EXCEPTION IFV_Go ENTRY nowhere;", "there is no entry nowhere"),
    ("EXCEPTION_ENTRY out; EXCEPTION_ENTRY out;", "the entry out appears twice"),
    ("CONDITION CRV_Size;", "this is a number; expected a flag"),
    ("WAIT_TIME IFV_Go;", "this is a flag; expected a number"),
    ("TMP_Master << CNV_Belt;", "TMP_Master is a TMP_GENERATOR; expected a CONVERTER"),
    ("CNV_Belt << AMP_Gear;", "AMP_Gear is an AMPLIFIER; expected a SAMPLER, TMP_GENERATOR or PMP_GENERATOR"),
    ("CNV_Belt << DIS_Slow << AMP_Gear << TMP_Master;", "the distributor DIS_Slow is inside the pipe"),
    (
        "CNV_Belt << AMP_Gear << TMP_Master; CNV_Sink << AMP_Gear << CAM_Feed << TMP_Master;",
        "AMP_Gear has another input in the pipe of line",
    ),
    ("CNV_Belt << AMP_Gear << AMP_Gear << TMP_Master;", "AMP_Gear is twice in the pipe; expected each block once"),
    ("CNV_Belt << AMP_Gear << CAM_Feed << AMP_Gear << TMP_Master;", "AMP_Gear is twice in the pipe"),
    ("AMP_Gear:GAIN <- RISING;", "RISING cannot be a value in an expression"),
    ("CNV_Belt <- connect(ENC_Belt);", "the argument is wrong; expected an AXIS"),
]


@pytest.mark.parametrize(("statements", "expected"), WRONG)
def test_wrong_statements(statements: str, expected: str) -> None:
    assert expected in said(in_sequence(statements))


SAMPLED = "ADDRESS = 1; ACTIVE = LOW; PERIOD = 1; DEBOUNCE = 2; END"
CAM_SIZE = "INPUT_AMPLITUDE = 1; OUTPUT_AMPLITUDE = 1; INPUT_OFFSET = 0; OUTPUT_OFFSET = 0; END"
DECLARATIONS = [
    ("NODE NOD_Belt; ADDRESS = 5; TYPE = ST1; END", "NOD_Belt is declared already in line"),
    ("NODE NOD_a; TYPE = ST1; END", "a NODE is not complete; expected ADDRESS = ..."),
    ("NODE NOD_a; NUMBER = 2; NODES_GROUP = NGR_Stations; ADDRESS = 1; TYPE = ST1; END", "not both"),
    ("LED_OUTPUT LED_a; NODE = NOD_Belt; ADDRESS = 1; END", "is on NOD_Belt, which is an ST1; expected a node of"),
    ("LED_OUTPUT LED_a; NODE = AXI_Belt; ADDRESS = 1; END", "AXI_Belt is an AXIS; expected a NODE"),
    ("DISTRIBUTOR DIS_a; DIVISOR = 5; SHIFT = 5; END", "SHIFT is 5; expected less than DIVISOR, which is 5"),
    ("CONVERTER CNV_a; DESTINATION = AXS_All; MODE = TORQUE; END", "an AXES_SET has no mode TORQUE"),
    ("DERIVATOR DER_a; VALUE_RANGE = 5 5; END", "VALUE_RANGE ends at 5; expected a number above 5"),
    ("DERIVATOR DER_a; END", "a DERIVATOR has none of VALUE_PERIOD or VALUE_RANGE"),
    (f"KEY_INPUT KEY_a; NODE = NOD_Desk; MODE = TOGGLE; {SAMPLED}", "no DEB"),
    ("ZERO_POSITIONER ZEP_a; OBJECT = AXI_Belt; COARSE_SPEED = 5; END", "the phase COARSE is not complete"),
    (f"DIGITAL_INPUT SDI_a; NODE = NOD_Desk; BITS = 13; {SAMPLED}", "1 to 12"),
    (f"PROFILE PRO_a; FILE = TOOLONGNAME; {CAM_SIZE}", "up to 8"),
    ("COMPARATOR CMP_a; REFERENCE = 1; ROUTINE = RTN_Show WITH CRV_Size, 1; END", "is not a constant here"),
    (
        "BOOLEAN BOL_a; LINKED_OUTPUT = IFV_Go; EQUATION IFV_Go; END_BOOLEAN",
        "expected a BINARY_OUTPUT, an LED_OUTPUT or",
    ),
    (
        "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT IFV_Go ACTION WAIT_TIME 5; END_ACTION END_ACTIONS",
        "not wait",
    ),
    ("ROUTINES RGR_a; ROUTINE RTN_a; CALL RTN_a; END_ROUTINE END_ROUTINES", "RTN_a calls itself"),
    ("ROUTINES RGR_a; ROUTINE RTN_a WITH a, b, c, d, e; END_ROUTINE END_ROUTINES", "at most 4, each once"),
    ("TASK TSK_a; SEQUENCE SEQ_a; END_SEQUENCE SEQUENCE SEQ_a; END_SEQUENCE END_TASK", "has the sequence SEQ_a"),
]


@pytest.mark.parametrize(("item", "expected"), DECLARATIONS)
def test_wrong_declarations(item: str, expected: str) -> None:
    assert expected in said(f"{MACHINE}{item}\n")


PIPE_RULES = [
    pytest.param(item, expected, marks=pytest.mark.manual(row))
    for row, item, expected in [
        ("PAML-170", "CONVERTER CNV_a; DESTINATION = AXS_All; MODE = TORQUE; END", "expected POSITION or SPEED"),
        ("PAML-481", "CONVERTER CNV_a; DESTINATION = AXI_Belt; MODE = VALUE; END", "POSITION, SPEED or TORQUE"),
    ]
]


@pytest.mark.parametrize(("item", "expected"), PIPE_RULES)
def test_rules_of_converters(item: str, expected: str) -> None:
    assert expected in said(f"{MACHINE}{item}\n")


PIPE_STATEMENTS = [
    pytest.param(statement, expected, marks=pytest.mark.manual(row))
    for row, statement, expected in [
        ("PAML-401", "CNV_Belt << TMP_Master << AMP_Gear;", "TMP_Master is a TMP_GENERATOR; expected a transformer"),
        ("PAML-541", "CNV_Belt << DIS_Slow << AMP_Gear << TMP_Master;", "the place behind its input"),
        ("PAMS-039", "CRV_Size <- CAM_Feed ? status;", "a CAM does not know the inquiry status"),
    ]
]


@pytest.mark.parametrize(("statement", "expected"), PIPE_STATEMENTS)
def test_rules_of_pipes(statement: str, expected: str) -> None:
    assert expected in said(in_sequence(statement))


@pytest.mark.manual("PAML-276")
def test_constants_of_a_connected_routine_have_signs() -> None:
    assert said(f"{MACHINE}COMPARATOR CMP_a; REFERENCE = 1; ROUTINE = RTN_Show WITH -1.5, +2; END\n") == ""


def test_an_application_begins_with_its_header() -> None:
    assert "does not begin with APPLICATION" in said("NODE NOD_a; ADDRESS = 1; TYPE = ST1; END")
    assert said(HEADER) == ""


@pytest.mark.manual("PAML-015")
@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("TASK TSK_b; SPECS PERIOD = 10; END_SPECS END_TASK", "Release 2.5 calls it CYCLES."),
        ("AXES_SET AXS_b; AXIS = AXI_Belt SHIFT = 1; END", "Release 2.5 calls it SUBSET."),
        (
            "TASK TSK_b; SEQUENCE SEQ_b; AXI_Belt <- travel_speed(720); END_SEQUENCE END_TASK",
            "Release 2.5 writes AXI_Belt:TRAVEL_SPEED <- value.",
        ),
    ],
)
def test_names_of_earlier_releases_are_notes(text: str, hint: str) -> None:
    (note,) = checked(f"{MACHINE}{text}\n", "x")[1]
    assert (note.is_note, note.hint) == (True, hint)


APPENDIX_A = """
    ABORT AXES_SET BIT BREAKING COARSE_MOVE CURRENT DUPL ERROR FIFO_IN_HEAD GAIN_SLOPE HEXA LOCATION MASTER_TIMEOUT
    NEXT_PERIOD PORT RANGE RS422 ST1_CMD SUBSET TIME_ORIGIN_SLOPE VME WATCH_DOG XEQ_ACTION ZERO
    abs anti_delay change_ratio disactivate end_error generator_position latched_dd_value ln modify_value no_blink
    power_on reference set stroke_limits travel_speed triggered zero_position
"""


@pytest.mark.manual("PAMS-102")
@pytest.mark.parametrize("word", APPENDIX_A.split())
def test_no_object_has_a_reserved_word_as_its_name(word: str) -> None:
    assert "reserved word" in said(HEADER + f"INTERNAL WORD_VAR {word};\n")
