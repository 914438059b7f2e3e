"""Declarations of ports to a PLC (sections 11.8, 12.5 and 13.1; T25, T28, T30, T31)."""

import pytest
from pam_ports import GROUP, RS422, SIMATIC, VME
from pam_programs import HEADER, MACHINE, in_sequence, mistakes_of

from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.formatter import formatted
from fieldrig_devices.pam.language.ports import PortPlan, crc_of, period_of, ports_of

SEQUENCE = "TASK TSK_a; SEQUENCE SEQ_a;\n{0}\nEND_SEQUENCE END_TASK\n"


def plan_of(text: str) -> PortPlan:
    program, mistakes = checked(HEADER + GROUP + text, "ports.pam")
    assert mistakes == []
    (found,) = ports_of(program)
    return found


@pytest.mark.manual("PAMS-082", "PAMS-085", "PAMS-087")
def test_the_listing_of_vme() -> None:
    plan = plan_of(VME)
    shown = [
        (variable.is_input, variable.kind, variable.name, variable.number, variable.period, variable.compiler_id)
        for variable in plan.variables
    ]
    assert shown == [
        (True, "FLAG_VAR", "DFI_MachRunning", 1, 20, 0),
        (True, "FLAG_VAR", "DFI_MachAlarm", 1, 10, 1),
        (True, "FLAG_VAR", "DFI_MachHeadReady", 4, 20, 2),
        (True, "FLAG_VAR", "DFI_MachHeadStopped", 6, 20, 3),
        (True, "WORD_VAR", "DWI_MachPressure", 1, 5, 0),
        (True, "LONG_VAR", "DLI_MachHeadSpeed", 6, 20, 0),
        (True, "REAL_VAR", "DRI_MachHeadFactor", 6, 20, 0),
        (False, "FLAG_VAR", "DFO_MachStopped", 1, 20, 0),
        (False, "WORD_VAR", "DWO_MachCurrentPressure", 1, 50, 0),
        (False, "LONG_VAR", "DLO_MachHeadPosition", 4, 20, 0),
        (False, "REAL_VAR", "DRO_MachHeadLevel", 4, 20, 0),
    ]
    assert plan.timeout_ms("MASTER_READY_TIMEOUT") == 500
    assert plan.timeout_ms("MASTER_CONFIGURATION_TIMEOUT") is None


@pytest.mark.manual("PAMS-094", "PAMS-095", "PAMS-096")
def test_the_listing_of_simatic() -> None:
    plan = plan_of(SIMATIC)
    at = {variable.name: (variable.address, variable.bit, variable.reserved) for variable in plan.variables}
    assert at["DFI_MachEmergency"] == (0x105, 3, 1)
    assert at["DFI_MachHeadReady"] == (0x106, 0, 48)
    assert at["DWO_MachHeadPosition"] == (0x922, 0, 48)
    assert plan.numbers("PAM_READY") == [0xFEE, 3]
    assert len(plan.inputs) == 7
    assert len(plan.outputs) == 7


@pytest.mark.manual("PAMS-095", "PAMS-096", "PAMS-057")
def test_the_map_of_the_listing_of_simatic() -> None:
    """The first byte of each variable and the one behind the room that it reserves."""
    plan = plan_of(SIMATIC)
    places = [
        (variable.address, variable.address + (2 * variable.reserved if "WORD" in variable.kind else 6))
        for variable in plan.variables
        if variable.reserved == 48
    ]
    assert places == [
        (0x106, 0x10C), (0x10C, 0x112), (0x122, 0x182), (0x182, 0x188),
        (0x906, 0x90C), (0x90C, 0x912), (0x922, 0x982), (0x982, 0x988),
    ]  # fmt: skip
    singles = [(variable.address, variable.bit) for variable in plan.variables if variable.reserved == 1]
    assert singles == [(0x104, 0), (0x105, 3), (0x120, 0), (0x904, 5), (0x905, 5), (0x920, 0)]
    cells = ("FIFO_IN_START", "FIFO_IN_HEAD", "FIFO_IN_TAIL", "FIFO_OUT_START", "FIFO_OUT_HEAD", "FIFO_OUT_TAIL")
    assert [plan.numbers(name)[0] for name in cells] == [0, 0x100, 0x102, 0x800, 0x900, 0x902]
    flags = ("PAM_READY", "DUALPORT_READY", "HOST_READY")
    assert [plan.numbers(name) for name in flags] == [[0xFEE, 3], [0xFEE, 4], [0x104, 4]]
    assert (plan.numbers("WATCH_DOG"), plan.numbers("PERIOD")) == ([0xFFE], [10])
    timeouts = ("MASTER_READY_TIMEOUT", "MASTER_CONFIGURATION_TIMEOUT", "MASTER_INACTIVITY_TIMEOUT")
    assert [plan.timeout_ms(name) for name in timeouts] == [20_000, None, 500]


@pytest.mark.manual("PAMS-099", "PAMS-101")
def test_the_listing_of_rs422() -> None:
    plan = plan_of(RS422)
    assert [variable.name for variable in plan.outputs] == [
        "RFO_MachStopped",
        "RWO_MachCurrentPressure",
        "RLO_MachHeadPosition",
        "RRO_MachHeadLevel",
    ]
    assert {variable.period for variable in plan.variables} == {20}
    assert plan.timeout_ms("PAM_WATCHDOG_MESSAGE_PERIOD") == 500


@pytest.mark.parametrize("text", [VME, SIMATIC, RS422])
def test_the_listings_compile_if_names_are_the_same_in_any_case(text: str) -> None:
    assert checked(HEADER + GROUP + text, "x", ignores_case=True)[1] == []


@pytest.mark.parametrize("text", [VME, SIMATIC, RS422])
def test_the_listings_are_formatted(text: str) -> None:
    once = formatted(HEADER + GROUP + text)
    assert formatted(once) == once
    assert "\n    PERIOD = 10;\n  END\n" in once or text is not VME
    assert plan_of(formatted(text)).variables == plan_of(text).variables


@pytest.mark.manual("PAMS-085")
@pytest.mark.parametrize(
    ("duration_ms", "thirds", "period"),
    [(1, 3, 1), (2, 3, 5), (5, 3, 5), (6, 3, 10), (20, 3, 20), (21, 3, 50), (90, 3, 50), (1, 1, 5), (4, 6, 5)],
)
def test_a_period_is_rounded_up(duration_ms: int, thirds: int, period: int) -> None:
    assert period_of(duration_ms, thirds) == period


def test_a_variable_with_one_item_is_single() -> None:
    plan = plan_of(VME.replace("NUMBER = 6", "NUMBER = 1", 1))
    assert [variable.name for variable in plan.inputs if variable.is_multiple] == [
        "DFI_MachHeadReady",
        "DLI_MachHeadSpeed",
        "DRI_MachHeadFactor",
    ]


def test_crc_of_a_name() -> None:
    assert crc_of("123456789") == 0x29B1  # the check value of CRC-16/CCITT-FALSE
    assert crc_of("dfi_a") == crc_of("DFI_A")


@pytest.mark.parametrize(
    "text",
    [
        VME.replace("DFO_MachStopped ;", "DFO_MachStopped ; END"),
        VME.replace("DFO_MachStopped ;", "DFO_MachStopped"),  # as in the boxes of the manual
        VME.replace("    NUMBER = 6 ;\n  END\n", "    NUMBER = 6 ;\n"),
        SIMATIC.replace("#105 BIT 3", "#105 BIT = 3"),
        SIMATIC.replace("#104 BIT 0", "#104"),
        RS422.replace("RWO_MachCurrentPressure ;\n  END", "RWO_MachCurrentPressure ;"),
        VME.replace("= 500", "= NONE"),
    ],
)
def test_tolerated_forms(text: str) -> None:
    assert mistakes_of(HEADER + GROUP + text) == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("DEFAULT_PERIOD = 20", "DEFAULT_PERIOD = 7", "expected 1, 5, 10, 20 or 50 basic cycles"),
        ("    MASTER_READY_TIMEOUT = 500 ;\n", "", "expected MASTER_READY_TIMEOUT = ..."),
        ("NUMBER = 6", "NUMBER = 0", "expected 1 or more"),
        ("PERIOD = 10", "PERIOD = 0", "expected a number above 0"),
        ("INPUT WORD_VAR", "INPUT BYTE_VAR", "expected FLAG_VAR, WORD_VAR, LONG_VAR or REAL_VAR"),
        ("INPUT WORD_VAR", "WORD_VAR", "expected INPUT, OUTPUT or END_DUALPORT"),
        ("DWI_MachPressure", "DFI_MachAlarm", "declared already"),
        ("NGR_PrintHeads ; // conf", "NGR_Heads ; // conf", "NGR_Heads is not declared"),
        ("DFI_MachRunning", "DFI_MACHALARM", "DFI_MachAlarm has the same CRC #BC4B as DFI_MACHALARM"),
        ("END_DUALPORT", "END_DUALPORT\n" + VME, "one DualPort and one RS422 port at most"),
        ("END_DUALPORT", "END_DUALPORT DUALPORT_IN FLAG_VAR a; ADDRESS = 4; END", "a declaration of DUAL_PORT"),
    ],
)
def test_wrong_ports(old: str, new: str, said: str) -> None:
    assert said in str(mistakes_of(HEADER + GROUP + VME.replace(old, new, 1))[0])


@pytest.mark.manual("PAMS-095", "PAMS-057", "PAMS-089")
@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("DWI_MachPressure ; ADDRESS = #120", "DWI_MachPressure ; ADDRESS = #121", "expected an even address"),
        ("DWI_MachPressure ; ADDRESS = #120", "DWI_MachPressure ; ADDRESS = #122", "overlaps DWI_MachPressure at #122"),
        ("#105 BIT 3", "#105 BIT 8", "expected a bit from 0 to 7"),
        ("#105 BIT 3", "#104 BIT 0", "DFI_MachEmergency overlaps DFI_MachRunning at #104 bit 0"),
        ("#105 BIT 3", "#104 BIT 4", "DFI_MachEmergency overlaps HOST_READY at #104 bit 4"),
        ("#105 BIT 3", "#10A BIT 3", "overlaps DFI_MachEmergency at #10A bit 3"),
        ("ADDRESS = #106 ;    // size", "ADDRESS = #107 ;    // size", "expected bit 0 of an even address"),
        ("RESERVED = MaxHead", "RESERVED = 3", "expected at least 4, the number of its items"),
        ("#0100", "#0102", "FIFO_IN_HEAD is at #102"),
        ("FIFO_IN_TAIL       = #0102", "FIFO_IN_TAIL       = #0100", "FIFO_IN_TAIL overlaps FIFO_IN_HEAD"),
        ("#0FEE BIT 3", "#0FF0 BIT 3", "PAM_READY overlaps the fatal error panel"),
        ("= #0FFE", "= #0FFF", "expected an even address"),
        ("#982", "#FF0", "overlaps the fatal error panel"),
        ("#982", "#FFF0", "expected a place below #1000"),
        ("  PERIOD              = 10 ;", "  PERIOD = 11;", "expected 1, 5, 10, 20 or 50 basic cycles"),
    ],
)
def test_wrong_places_in_a_simatic_dual_port(old: str, new: str, said: str) -> None:
    text = SIMATIC.replace(old, new, 1)
    found = [str(mistake) for mistake in mistakes_of(HEADER + GROUP + text)]
    assert any(said in message for message in found), found


def test_single_and_multiple_flags_of_inputs_are_not_mixed() -> None:
    mixed = SIMATIC.replace("RESERVED = MaxHead", "RESERVED = 4").replace("#105 BIT 3", "#107 BIT 3")
    (found,) = mistakes_of(HEADER + GROUP + mixed)
    assert "shares cell #106 with flags of the other sort" in str(found)
    outputs = SIMATIC.replace("RESERVED = MaxHead", "RESERVED = 4").replace("#905 BIT 5", "#907 BIT 3")
    assert mistakes_of(HEADER + GROUP + outputs) == []


@pytest.mark.manual("PAMS-084", "PAMS-083")
@pytest.mark.parametrize(
    "statement",
    [
        "WAIT_TIME( DualPort:MASTER_INACTIVITY_TIMEOUT);",
        "DualPort:MASTER_INACTIVITY_TIMEOUT <- 500;",
        "DualPort:MASTER_INACTIVITY_TIMEOUT <- NONE;",
        "WAIT_TIME DualPort:MASTER_READY_TIMEOUT;",
        "IF DualPort ? error THEN DFO_MachStopped <- set; END_IF",
        "IF DualPort ? error_code(2) THEN DFO_MachStopped <- invert; END_IF",
        "DLO_MachHeadPosition[all] <- 70000;",
        "DWO_MachCurrentPressure <- DWI_MachPressure + 1;",
    ],
)
def test_what_programs_do_with_a_port(statement: str) -> None:
    assert mistakes_of(HEADER + GROUP + VME + SEQUENCE.format(statement)) == []


@pytest.mark.manual("PAMS-084", "PAMS-085")
@pytest.mark.parametrize(
    ("statement", "said"),
    [
        ("DualPort:MASTER_READY_TIMEOUT <- 500;", "cannot be changed by a program"),
        ("DualPort:MASTER_CONFIGURATION_TIMEOUT <- 500;", "cannot be changed by a program"),
        ("DualPort:DEFAULT_PERIOD <- 5;", "has no parameter DEFAULT_PERIOD"),
        ("DFI_MachAlarm <- set;", "DFI_MachAlarm is an input of a port"),
        ("DWI_MachPressure <- 4;", "DWI_MachPressure is an input of a port"),
        ("DLO_MachHeadPosition <- 4;", "has several items"),
    ],
)
def test_what_programs_must_not_do_with_a_port(statement: str, said: str) -> None:
    assert said in str(mistakes_of(HEADER + GROUP + VME + SEQUENCE.format(statement))[0])


def test_rs422_has_its_own_parameters() -> None:
    for statement in (
        "WAIT_TIME( RS422Port:MASTER_INACTIVITY_TIMEOUT);",
        "RS422Port:PAM_WATCHDOG_MESSAGE_PERIOD <- 9;",
    ):
        assert mistakes_of(HEADER + GROUP + RS422 + SEQUENCE.format(statement)) == []
    for name in ("MASTER_READY_TIMEOUT", "MASTER_CONFIGURATION_TIMEOUT"):
        (refused,) = mistakes_of(HEADER + GROUP + RS422 + SEQUENCE.format(f"RS422Port:{name} <- 9;"))
        assert "cannot be changed by a program" in str(refused)
    wrong = mistakes_of(in_sequence("DualPort:PAM_WATCHDOG_MESSAGE_PERIOD <- 5;"))
    assert "a DUALPORT has no parameter PAM_WATCHDOG_MESSAGE_PERIOD" in str(wrong[0])


@pytest.mark.manual("PAML-241")
def test_an_equation_is_linked_to_an_output_flag_of_a_port() -> None:
    linked = "BOOLEAN BOL_a; LINKED_OUTPUT = {0}; EQUATION DFI_MachAlarm; END_BOOLEAN\n"
    assert mistakes_of(HEADER + GROUP + VME + linked.format("DFO_MachStopped")) == []
    for name in ("DFI_MachRunning", "DWO_MachCurrentPressure"):
        (found,) = mistakes_of(HEADER + GROUP + VME + linked.format(name))
        assert "an output flag of a port" in str(found)


def test_a_machine_with_two_ports() -> None:
    assert mistakes_of(MACHINE + GROUP + VME + RS422) == []
