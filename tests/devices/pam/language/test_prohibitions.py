"""Prohibitions of the manual that a checker can see: addresses, sharing, numbers, texts and times."""

import pytest
from pam_programs import MACHINE, in_sequence, mistakes_of

from fieldrig_devices.pam.language.compiler import checked

SAMPLED = "ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END"
OTHER = "NODE NOD_b; ADDRESS = 99; TYPE = SMART_IO; END "
PROBE = "UNITS_PER_VOLT = 1; OFFSET = 0; ADDRESS = 1; END"


def said(text: str) -> str:
    return "\n".join(map(str, mistakes_of(text)))


CHANNELS = [*range(101, 113), *range(201, 213), *range(901, 913), *range(1601, 1613)]
NO_CHANNELS = [0, 1, 12, 99, 100, 113, 199, 200, 213, 1600, 1613, 1701, 10101, 4294967295]


@pytest.mark.manual("PAML-080")
@pytest.mark.parametrize("kind", ["BINARY_INPUT", "DIGITAL_INPUT", "COUNTER_INPUT", "KEY_INPUT"])
@pytest.mark.parametrize("address", [*CHANNELS, *NO_CHANNELS])
def test_inputs_of_a_smart_io(kind: str, address: int) -> None:
    more = {"DIGITAL_INPUT": "BITS = 1;", "KEY_INPUT": "MODE = TOGGLE; ON BINARY_INPUT"}.get(kind, "")
    found = said(f"{MACHINE}{kind} X; NODE = NOD_Desk; {more} ADDRESS = {address}; {SAMPLED}")
    assert (f"ADDRESS is {address}; expected a module" in found) is (address in NO_CHANNELS)
    assert bool(found) is (address in NO_CHANNELS)


@pytest.mark.manual("PAMS-110")
@pytest.mark.parametrize("address", [101, 102, 103, 200, 201, 208, 209, 216, 217, 301, 0])
def test_inputs_and_outputs_of_an_st1(address: int) -> None:
    head = f"{MACHINE}{{}} X; NODE = NOD_Belt; ADDRESS = {address};"
    is_input, is_output = address in (101, 102, *range(201, 217)), address in range(201, 209)
    assert (said(head.format("BINARY_INPUT") + SAMPLED) == "") is is_input
    assert (said(head.format("BINARY_OUTPUT") + "ACTIVE = HIGH; END") == "") is is_output


@pytest.mark.parametrize(
    ("address", "bits", "is_right"), [(205, 8, True), (205, 9, False), (212, 1, True), (212, 2, False)]
)
def test_a_digital_object_ends_in_its_module(address: int, bits: int, is_right: bool) -> None:
    found = said(f"{MACHINE}DIGITAL_INPUT X; NODE = NOD_Desk; BITS = {bits}; ADDRESS = {address}; {SAMPLED}")
    assert found == "" if is_right else f"expected an address with {bits} positions" in found


@pytest.mark.parametrize(
    ("item", "expected"),
    [
        ("ANALOG_OUTPUT X; NODE = NOD_Desk; RANGE = 0 1; ADDRESS = 2; END", "1, the analog output of a SMART_IO"),
        ("D7SEG_OUTPUT X; NODE = NOD_Desk; DIGITS = 1; ADDRESS = 2; END", "1, the display of a SMART_IO"),
        (f"{OTHER}D7SEG_OUTPUT X; NODE = NOD_b; DIGITS = 4; ADDRESS = 1; END", "DIGITS is 4; expected 1"),
        ("PAM_ANALOG_OUTPUT X; UNITS_PER_VOLT = 1; OFFSET = 0; ADDRESS = 2; END", "0 or 1, the analog outputs"),
        ("PAM_ANALOG_OUTPUT X; UNITS_PER_VOLT = 0; OFFSET = 0; ADDRESS = 1; END", "UNITS_PER_VOLT is 0"),
        ("LED_OUTPUT X; NODE = NOD_Desk; ADDRESS = 0; END", "expected 1 or more"),
        ("ENCODER X; NODE = NOD_Belt; ADDRESS = 5; PULSES_PER_UNIT = 1; POSITION_PERIOD = 1; END", "(table 2-2)"),
        ("ENCODER X; NODE = NOD_Belt; ADDRESS = 256; PULSES_PER_UNIT = 1; POSITION_PERIOD = 1; END", "(table 2-2)"),
        ("NODE X; ADDRESS = -4; TYPE = ST1; END", "ADDRESS is -4; expected a number that is not negative"),
        (f"BINARY_INPUT X; NODE = NOD_Desk; ADDRESS = -101; {SAMPLED}", "ADDRESS is -101; expected a number that is"),
        (f"DIGITAL_INPUT X; NODE = NOD_Desk; BITS = -3; ADDRESS = 301; {SAMPLED}", "BITS is -3; expected a number"),
        (f"DIGITAL_INPUT X; NODE = NOD_Desk; BITS = 13; ADDRESS = 301; {SAMPLED}", "BITS is 13; expected 1 to 12"),
        ("NODES_GROUP X; NUMBER = 0; END", "NUMBER is 0; expected 1 or more"),
        ("ENCODER X; NODE = NOD_Belt; ADDRESS = 1; PULSES_PER_UNIT = 0; POSITION_PERIOD = 1; END", "that is not 0"),
        ("APPLICATION NAME = other V1.00; BASIC_PAM_CYCLE = 3; END", "there is a second APPLICATION; expected one"),
        ("NODE X; ADDRESS = 0; TYPE = ST1; END", "ADDRESS is 0; expected 1 to 255"),
        ("NODE X; ADDRESS = 256; TYPE = ST1; END", "ADDRESS is 256; expected 1 to 255"),
        ("NODE X; NUMBER = 3; ADDRESS = 254; TYPE = ST1; END", "the addresses are 254 to 256; expected 1 to 255"),
        ("NODE X; NUMBER = 0; ADDRESS = 99; TYPE = ST1; END", "NUMBER is 0; expected 1 or more"),
        ("BINARY_INPUT X; NODE = NOD_Desk; ADDRESS = 101; ACTIVE = LOW; PERIOD = 0; DEBOUNCE = 1; END", "PERIOD is 0"),
        ("AXES_SET X; AXIS = AXI_Belt SUBSET = -1; END", "SUBSET is -1; expected a number that is not negative"),
        ("AXES_SET X; AXIS = AXI_Belt SUBSET = 1.5; END", "SUBSET is 1.5; expected a whole number"),
    ],
)  # fmt: skip
def test_addresses_and_numbers(item: str, expected: str) -> None:
    found = said(MACHINE + item)
    assert expected in found
    assert found.count("packer.pam") == 1


AXIS = (
    "AXIS X; NODE = {}; PULSES_PER_UNIT = 1; TRAVEL_SPEED = 1; ACCELERATION = 1; INITIAL_POSITION = 0;"
    " POSITION_PERIOD = 360; END"
)


@pytest.mark.manual("PAML-040")
def test_an_st1_has_one_axis() -> None:
    found = said(MACHINE + AXIS.format("NOD_Belt"))
    assert "X and AXI_Belt are axes of NOD_Belt; expected another ST1 for each axis" in found
    assert found.count("packer.pam") == 1
    assert said(f"{MACHINE}NODE NOD_New; ADDRESS = 9; TYPE = ST1; END {AXIS.format('NOD_New')}") == ""


# MACHINE has the nodes 1, 2, 3 and 17, and the outputs 201 and 202 to 207 on the last of them.
SHARED = [
    ("NODE X; ADDRESS = 17; TYPE = ST1; END", "X and NOD_Desk have the address 17"),
    ("NODE X; ADDRESS = 3; TYPE = ST1; END", "X and NOD_Station have the address 3"),
    ("NODE X; NUMBER = 4; ADDRESS = 15; TYPE = SMART_IO; END", "X and NOD_Desk have the address 17"),
    ("BINARY_OUTPUT X; NODE = NOD_Desk; ADDRESS = 201; ACTIVE = LOW; END", "X and SBO_Lamp have the address 201"),
    ("BINARY_OUTPUT X; NODE = NOD_Desk; ADDRESS = 207; ACTIVE = LOW; END", "X and SDO_Code have the address 207"),
    ("DIGITAL_OUTPUT X; NODE = NOD_Desk; BITS = 2; ADDRESS = 207; ACTIVE = LOW; END", "X and SDO_Code have"),
    ("LED_OUTPUT X; NODE = NOD_Desk; ADDRESS = 6; END", "X and LED_Run have the address 6"),
    ("D7SEG_OUTPUT X; NODE = NOD_Desk; DIGITS = 1; ADDRESS = 1; END", "X and D7S_Digit have the address 1"),
    (f"PAM_ANALOG_OUTPUT X; {PROBE} PAM_ANALOG_OUTPUT Y; {PROBE}", "Y and X have the address 1"),
]  # fmt: skip


@pytest.mark.parametrize(("item", "expected"), SHARED)
def test_two_nodes_or_outputs_have_two_addresses(item: str, expected: str) -> None:
    found = said(MACHINE + item)
    assert expected in found
    assert found.count("packer.pam") == 1


@pytest.mark.parametrize(
    "item",
    [
        "NODE X; NUMBER = 3; ADDRESS = 14; TYPE = SMART_IO; END",
        "BINARY_OUTPUT X; NODE = NOD_Desk; ADDRESS = 208; ACTIVE = LOW; END",
        f"BINARY_INPUT X; NODE = NOD_Desk; ADDRESS = 101; {SAMPLED}",  # SBI_Start reads it too
        f"BINARY_INPUT X; NODE = NOD_Desk; ADDRESS = 201; {SAMPLED}",  # SBO_Lamp has the number among the outputs
        "LED_OUTPUT X; NODE = NOD_Desk; ADDRESS = 1; END",
        "NODE N; ADDRESS = 99; TYPE = SMART_IO; END BINARY_OUTPUT X; NODE = N; ADDRESS = 201; ACTIVE = LOW; END",
    ],
)
def test_others_have_the_same_number(item: str) -> None:
    assert said(MACHINE + item) == ""


MOTOR = f"""NODE NOD_b; ADDRESS = 99; TYPE = SMART_IO; END
BINARY_OUTPUT SBO_Inc; NODE = NOD_Desk; ADDRESS = 301; ACTIVE = HIGH; END
BINARY_OUTPUT SBO_Dec; NODE = NOD_Desk; ADDRESS = 302; ACTIVE = HIGH; END
BINARY_INPUT SBI_Zero; NODE = NOD_Desk; ADDRESS = 301; {SAMPLED}
COUNTER_INPUT CNT_a; NODE = NOD_Desk; ADDRESS = 302; {SAMPLED}
DC_MOTOR DCM_a; INC = SBO_Inc; DEC = SBO_Dec; ZERO = SBI_Zero; ENCODER = CNT_a; TIMEOUT = 1; BRAKING = 1; END"""


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("", "", ""),
        ("DEC = SBO_Dec", "DEC = SBO_Inc", "INC and DEC are both SBO_Inc"),
        ("SBO_Dec; NODE = NOD_Desk", "SBO_Dec; NODE = NOD_b", "on several nodes or an ST1; expected one SMART_IO"),
        (
            "SBI_Zero; NODE = NOD_Desk; ADDRESS = 301",
            "SBI_Zero; NODE = NOD_Belt; ADDRESS = 201",
            "expected one SMART_IO",
        ),
        ("CNT_a; NODE = NOD_Desk; ADDRESS = 302", "CNT_a; NODE = NOD_Belt; ADDRESS = 202", "a node of TYPE SMART_IO"),
    ],
)
def test_a_motor_is_on_one_smart_io(old: str, new: str, expected: str) -> None:
    found = said(MACHINE + MOTOR.replace(old, new))
    assert expected in found
    assert bool(expected) is bool(found)


@pytest.mark.parametrize(
    ("specs", "expected"),
    [
        ("SPECS NUMBER = 2; END_SPECS", "the SPECS of the task have no CYCLES; expected CYCLES = n"),
        ("SPECS END_SPECS", "the SPECS of the task have no CYCLES; expected CYCLES = n"),
        ("SPECS CYCLES = 0; END_SPECS", "CYCLES is 0; expected 1 or more"),
        ("SPECS CYCLES = 1; DUPL = 0; END_SPECS", "DUPL is 0; expected 1 or more"),
        ("SPECS PERIOD = 1; END_SPECS", ""),
        ("", ""),
    ],
)
def test_cycles_of_a_task(specs: str, expected: str) -> None:
    found = said(f"{MACHINE}TASK TSK_a; {specs} END_TASK")
    assert expected in found
    assert bool(expected) is bool(found)


def test_the_cycle_is_not_zero() -> None:
    assert "BASIC_PAM_CYCLE is 0; expected 1 or more" in said("APPLICATION NAME = a V1.00; BASIC_PAM_CYCLE = 0; END")


@pytest.mark.manual("PAMS-046")
@pytest.mark.parametrize("function", ["message", "warning", "end_warning", "error", "end_error"])
@pytest.mark.parametrize(
    ("number", "text", "expected"),
    [
        ("0", "", ""),
        ("4095", "x" * 40, ""),
        ("#FFF", "x" * 40, ""),
        ("#1000", "", "the number of the message is 4096; expected 0 to #FFF, which is 4095"),
        ("4000 + 96", "", "the number of the message is 4096"),
        ("-1", "", "the number of the message is -1"),
        ("1", "x" * 41, "the text has 41 characters; expected at most 40"),
    ],
)
def test_messages(function: str, number: str, text: str, expected: str) -> None:
    found = said(in_sequence(f'PAMDISPLAY <- {function}({number}, "{text}", 1);'))
    assert expected in found
    assert bool(expected) is bool(found)


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("WAIT_TIME -5;", "the time is -5 ms; expected a time that is not negative"),
        ("WAIT_TIME (-0.5);", "the time is -0.5 ms"),
        ("WAIT_TIME 3 - 5;", "the time is -2 ms"),
        ("WAIT_TIME 2 * -3;", "the time is -6 ms"),
        ("WAIT_TIME 10 / -4;", "the time is -2 ms"),
        ("WAIT_TIME -7 % 4;", "the time is -3 ms"),
        ("WAIT_TIME 3 - 9 / 2.0;", "the time is -1.5 ms"),
        ("WAIT_TIME 5 % -3;", ""),
        ("WAIT_TIME 5 / 0;", ""),
        ("WAIT_TIME 0;", ""),
        ("WAIT_TIME -CRV_Size;", ""),
        ('D7S_Digit <- display("AB");', "the text has 2 characters; expected 1"),
        ("D7S_Digit <- display(7, 2);", "2 digits are to be shown; expected 1"),
    ],
)
def test_constants_of_statements(statement: str, expected: str) -> None:
    found = said(in_sequence(statement))
    assert expected in found
    assert bool(expected) is bool(found)


ACTION = "ACTIONS ACT_a; SPECS CYCLES = 1; END_SPECS ON_EVENT IFV_Go ACTION {} END_ACTION END_ACTIONS"
PMP = """PMP_GENERATOR PMP_a; FIRST_TRAVEL_SPEED = 1; LAST_TRAVEL_SPEED = 1; ACCELERATION = 1; JERK = 1; PERIOD = 0.001;
INITIAL_POSITION = 0; POSITION_PERIOD = 1; END """


@pytest.mark.parametrize(
    ("text", "note"),
    [
        (in_sequence("CONDITION IFV_Go TIMEOUT -1;"), "the time-out is -1 ms"),
        (in_sequence("EXCEPTION IFV_Go TIMEOUT -1 ABORT_SEQUENCE;"), "the time-out is -1 ms"),
        (in_sequence("PMP_a <- relative_move(5, 2);").replace("TASK", PMP + "TASK", 1), "both displacements have one"),
        (MACHINE + ACTION.format("CRV_Size <- ENC_Belt ? position;"), "an action does not wait for an inquiry"),
        (MACHINE + ACTION.format("CRV_Size <- ENC_Belt;"), "an action does not wait for an inquiry"),
    ],
)
def test_what_the_pam_answers_at_run_time_is_a_note(text: str, note: str) -> None:
    (found,) = checked(text, "x")[1]
    assert (found.is_note, note in found.what) == (True, True)
