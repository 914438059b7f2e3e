"""Cases of section 19 of the digest, as applications on a whole machine: the PAM, its ring, ST1 and Smart-IO nodes.

T01, T02, T21 and T24 are with the run time, T13 to T19, T23 and T31 in `test_acceptance_panel.py`, and T25 to T30 with
the ports.
"""

from pathlib import Path

import pytest
from pam_cases import TASK, Machine

pytestmark = pytest.mark.long


def test_t03_moves_of_one_axis_of_each_and_of_all(tmp_path: Path) -> None:
    multiple = TASK.replace("CYCLES = 1", "NUMBER = 2; CYCLES = 1").replace("SEQ_A;", "SEQ_A[i];")
    machine = Machine(
        tmp_path, "AXI_A[i] <- absolute_move(2.0 * IRV_Target[i]); CONDITION AXI_A[i] ? ready;", task=multiple
    )
    machine["IRV_Target[1]"], machine["IRV_Target[2]"] = 30.0, -45.0
    machine.go()
    assert (machine.degrees(1), machine.degrees(2)) == pytest.approx((60.0, -90.0), abs=1e-6)


def test_t03_moves_of_all_axes(tmp_path: Path) -> None:
    machine = Machine(tmp_path, "AXI_A[all] <- relative_move(20.0); CONDITION AXI_A[all*] ? ready;").go()
    assert machine["IWV_Step"] == 9
    assert (machine.degrees(1), machine.degrees(2)) == pytest.approx((20.0, 20.0), abs=1e-6)


PMP = """
PMP_GENERATOR PMP_A; FIRST_TRAVEL_SPEED = 9000.0; LAST_TRAVEL_SPEED = 9000.0; ACCELERATION = 45000.0; JERK = 450000.0;
  INITIAL_POSITION = 0.0; POSITION_RANGE = -1000000.0 1000000.0; PERIOD = 0.001; END
SINK SNK_A; END
CONVERTER CNV_A; DESTINATION = SNK_A; MODE = POSITION; END
"""


def test_t04_a_pmp_goes_forward_and_backward_and_not_twice_the_same_way(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """CNV_A << PMP_A; CONDITION CNV_A ? ready; PMP_A <- absolute_move(12000.0, 8000.0);
        CONDITION PMP_A ? ready; IRV_Value <- PMP_A ? position; IWV_Step <- 2; CONDITION !IFV_Go;
        PMP_A <- relative_move(100.0, 200.0); WAIT_TIME 1000; IRV_Value <- PMP_A ? position;""",
        PMP,
    ).go()
    machine.until("IWV_Step", 2)
    assert machine["IRV_Value"] == pytest.approx(8000.0)
    machine["IFV_Go"] = False
    machine.until("IWV_Step", 9)
    assert machine["IRV_Value"] == pytest.approx(8000.0)


SECOND = "NODE NOD_B; ADDRESS = 11; TYPE = ST1; END\n"
SINGLE = """
AXIS AXI_B; NODE = NOD_B; PULSES_PER_UNIT = 11930464.71111111; TRAVEL_SPEED = 360.0; ACCELERATION = 3600.0;
  INITIAL_POSITION = 0.0; POSITION_RANGE = -1000000.0 1000000.0; END
AXES_SET AXS_B; AXIS = AXI_A[all]; AXIS = AXI_B; END
CONVERTER CNV_B; DESTINATION = AXS_B; MODE = POSITION; END
"""
SET = "CONVERTER CNV_S; DESTINATION = AXS_A; MODE = POSITION; END\n"


def test_t05_ratios_of_one_axis_and_of_all(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """CNV_S << TMP_A; CONDITION CNV_S ? ready; CNV_S <- change_all_ratios(2.0); TMP_A <- absolute_move(10.0);
        CONDITION TMP_A ? ready;""",
        SET,
    ).go()
    assert (machine.degrees(1), machine.degrees(2)) == pytest.approx((20.0, 20.0), abs=1e-6)


def test_t05_the_ratio_of_one_axis_of_the_set(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """AXI_B <- power_on; CONDITION AXI_B ? ready; CNV_B << TMP_A; CONDITION CNV_B ? ready;
        CNV_B <- change_ratio(AXI_B, 3.0); TMP_A <- absolute_move(10.0); CONDITION TMP_A ? ready;""",
        SECOND + SINGLE,
    ).go()
    assert machine.degrees(2) == pytest.approx(10.0, abs=1e-6)
    assert float(machine.rig.get("nod_b", "set_position")) * 360 == pytest.approx(30.0, abs=1e-6)


def test_t06_a_disconnected_axis_holds_its_position_also_over_the_end_of_the_pipe(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """CNV_S << TMP_A; CONDITION CNV_S ? ready; TMP_A <- absolute_move(10.0); CONDITION TMP_A ? ready;
        CNV_S <- disconnect_all; TMP_A <- absolute_move(30.0); CONDITION TMP_A ? ready; IWV_Step <- 2;
        CNV_S <- disactivate; CNV_S << TMP_A; CONDITION CNV_S ? ready; TMP_A <- absolute_move(30.0);
        CONDITION TMP_A ? ready; IWV_Step <- 3; CONDITION !IFV_Go; CNV_S <- connect_all; WAIT_TIME 200;""",
        SET,
    ).go()
    machine.until("IWV_Step", 3)
    machine.wait(0.5)
    assert machine.degrees(1) == pytest.approx(10.0, abs=1e-6)
    machine["IFV_Go"] = False
    machine.until("IWV_Step", 9)
    assert machine.degrees(1) == pytest.approx(30.0, abs=1e-6)  # the axis jumps to the flow


def test_t06_a_single_axis_is_disconnected_from_a_speed(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """AXI_B <- power_on; CONDITION AXI_B ? ready; CNV_B << TMP_A; CONDITION CNV_B ? ready;
        TMP_A <- position(IRV_Value); WAIT_TIME 500; IWV_Step <- 2; CONDITION !IFV_Go; CNV_B <- disconnect(AXI_B);
        WAIT_TIME 500;""",
        SECOND + SINGLE.replace("MODE = POSITION", "MODE = SPEED"),
    )
    machine["IRV_Value"] = 720.0  # degrees per second
    machine.go(0.1).until("IWV_Step", 2)
    assert [machine.rig.get(node, "set_speed") for node in ("nod_a_1", "nod_b")] == pytest.approx([2.0, 2.0], abs=1e-6)
    machine["IFV_Go"] = False
    machine.until("IWV_Step", 9)
    assert [machine.rig.get(node, "set_speed") for node in ("nod_a_1", "nod_b")] == pytest.approx([2.0, 0.0], abs=1e-6)


CORRECTOR = """
BINARY_INPUT SBI_Mark; NODE = NOD_Io; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
CORRECTOR COR_A; CORRECTION_MODE = ON_REQUEST; CORRECTION_REFERENCE = OUTPUT; CORRECTION_SLOPE = 36000.0;
  CORRECTION_LEVEL = 360.0; TRIGGER_MODE = ONCE; TRIGGER_INPUT = SBI_Mark; DELAY_COMPENSATION = 0.0; END
SINK SNK_A; END
CONVERTER CNV_A; DESTINATION = SNK_A; MODE = POSITION; END
"""


def test_t07_a_correction_on_request_takes_the_value_that_it_is_given(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """CNV_A << COR_A << TMP_A; CONDITION CNV_A ? ready; COR_A <- trigger(90.0); IWV_Step <- 2;
        CONDITION COR_A ? triggered; COR_A <- start_correction(-180.0); CONDITION COR_A ? ready;
        IRV_Value <- COR_A ? value; COR_A <- trigger(90.0); COR_A <- trigger_off; IWV_Step <- 3;
        CONDITION COR_A ? triggered TIMEOUT 500; IFV_Seen <- TIMEOUT;""",
        CORRECTOR,
    ).go(0.5)
    machine.until("IWV_Step", 2)
    machine.rig.set("nod_io", "in101", True)
    machine.until("IWV_Step", 3)
    assert machine["IRV_Value"] == pytest.approx(-180.0, abs=1e-6)
    machine.rig.set("nod_io", "in101", False)
    machine.wait(0.1)
    machine.rig.set("nod_io", "in101", True)
    machine.until("IWV_Step", 9)
    assert machine["IFV_Seen"]  # the corrector was off


def test_t08_an_error_code_is_a_number_or_a_question_for_a_mask(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """CONDITION AXI_A[all+] ? error; IF AXI_A[all+] ? error_code(RESOLVER_FAILURE) THEN IFV_Seen <- set; END_IF""",
    )
    machine["IFV_Go"] = True
    machine.wait(0.2)
    assert machine["IWV_Step"] == 1
    machine.rig.add_fault("nod_a_1", {"what": "resolver"})
    machine.until("IWV_Step", 9)
    assert machine["IFV_Seen"]


def test_t08_an_error_code_is_a_number_and_a_motor_has_one_too(tmp_path: Path) -> None:
    motor = """
    BINARY_OUTPUT SBO_Inc; NODE = NOD_Io; ADDRESS = 101; ACTIVE = HIGH; END
    BINARY_OUTPUT SBO_Dec; NODE = NOD_Io; ADDRESS = 102; ACTIVE = HIGH; END
    BINARY_INPUT SBI_Zero; NODE = NOD_Io; ADDRESS = 102; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
    COUNTER_INPUT CNT_Pulses; NODE = NOD_Io; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
    DC_MOTOR DCM_A; INC = SBO_Inc; DEC = SBO_Dec; ZERO = SBI_Zero; ENCODER = CNT_Pulses; TIMEOUT = 200; BRAKING = 3; END
    """
    machine = Machine(
        tmp_path,
        """DCM_A <- run(INC); CONDITION DCM_A ? error; IFV_Seen <- DCM_A ? error_code(DCM_TIMEOUT);
        IWV_Code <- DCM_A ? error_code; IWV_Step <- 2; CONDITION AXI_B ? error; IWV_Code <- AXI_B ? error_code;""",
        '#include "SMARTERR.SYS"\n' + SECOND + SINGLE + motor,
    )
    machine["IFV_Go"] = True
    machine.until("IWV_Step", 2)  # no pulse has come within its time-out
    assert (machine["IFV_Seen"], machine["IWV_Code"]) == (True, 1)
    machine.rig.add_fault("nod_b", {"what": "resolver"})
    machine.until("IWV_Step", 9)
    assert int(str(machine["IWV_Code"])) & 0x0080_0000  # RESOLVER_FAILURE


def test_t09_a_pipe_is_motionless_when_its_last_set_point_has_arrived(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """CNV_S << TMP_A; CONDITION CNV_S ? ready; TMP_A <- absolute_move(50.0); WAIT_TIME 100;
        IFV_Seen <- AXS_A ? pipe_motionless; CONDITION TMP_A ? ready;
        CONDITION (AXS_A ? pipe_motionless) * (AXI_A[all*] ? pipe_motionless); CNV_S <- disactivate;""",
        SET,
    ).go()
    assert machine["IWV_Step"] == 9
    assert not machine["IFV_Seen"]  # while it moved
    assert machine.degrees(1) == pytest.approx(50.0, abs=1e-6)  # nothing was lost at the end of the pipe


def test_t10_a_led_is_set_at_the_start_of_a_motion_or_after_it(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """AXI_A[all] <- absolute_move(180.0); LED_A <- set; IWV_Step <- 2; CONDITION AXI_A[all*] ? ready;
        LED_A <- reset;""",
    )
    machine["IFV_Go"] = True
    machine.until("IWV_Step", 2)
    machine.wait(0.02)
    assert machine.rig.get("nod_io", "led1")
    assert machine.degrees(1) < 20
    machine.until("IWV_Step", 9)
    machine.wait(0.02)
    assert not machine.rig.get("nod_io", "led1")
    assert machine.degrees(1) == pytest.approx(180.0, abs=1e-6)


ENCODER = """
ENCODER ENC_A; NODE = NOD_B; ADDRESS = 0; PULSES_PER_UNIT = 182.0444444444; POSITION_RANGE = -1000000.0 1000000.0; END
SAMPLER SMP_A; SOURCE = ENC_A; MODE = POSITION; PERIOD = 0.001; END
SINK SNK_A; END
CONVERTER CNV_A; DESTINATION = SNK_A; MODE = POSITION; END
"""


def test_t11_a_reading_of_an_encoder_takes_six_or_seven_cycles_unless_it_is_sampled(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """IWV_Step <- 2; IRV_Value <- ENC_A ? position; IWV_Step <- 3; CONDITION !IFV_Go;
        CNV_A << SMP_A; CONDITION CNV_A ? ready; WAIT_TIME 50; IWV_Step <- 4; CONDITION IFV_Go; IWV_Step <- 5;
        IRV_Value <- ENC_A ? position; IWV_Step <- 6;""",
        SECOND + ENCODER,
    )
    machine["IFV_Go"] = True
    machine.until("IWV_Step", 2)
    assert machine.until("IWV_Step", 3) == pytest.approx(0.0065, abs=0.0016)
    machine["IFV_Go"] = False
    machine.until("IWV_Step", 4)
    machine["IFV_Go"] = True
    assert machine.until("IWV_Step", 9) <= 0.003


COMPARATOR = """
SINK SNK_A; END
CONVERTER CNV_A; DESTINATION = SNK_A; MODE = POSITION; END
COMPARATOR CMP_A; REFERENCE = 10.0; END
"""


def test_t12_a_comparator_is_ready_at_its_reference_and_the_old_name_is_an_alias_with_a_note(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """CNV_A << CMP_A << TMP_A; CONDITION CNV_A ? ready; CMP_A <- reference(40.0); TMP_A <- absolute_move(60.0);
        CONDITION CMP_A ? ready; IRV_Value <- TMP_A ? position;""",
        COMPARATOR,
    ).go()
    assert machine["IWV_Step"] == 9
    assert float(str(machine["IRV_Value"])) == pytest.approx(40.0, abs=0.3)
    assert [note for note in machine.notes if note.is_note and "reference" in note.what]


def test_t12_the_reference_through_zero_is_that_of_the_next_period(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """CNV_A << CMP_A << TMP_P; CONDITION CNV_A ? ready; TMP_P <- run(100.0); CONDITION TMP_P ? position > 50.0;
        CMP_A <- through_zero_reference(20.0); CONDITION CMP_A ? ready; IRV_Value <- TMP_P ? position;""",
        COMPARATOR
        + """TMP_GENERATOR TMP_P; TRAVEL_SPEED = 100.0; ACCELERATION = 1000.0; INITIAL_POSITION = 0.0;
        POSITION_PERIOD = 360.0; PERIOD = 0.001; END\n""",
    ).go(5.0)
    assert machine["IWV_Step"] == 9
    assert float(str(machine["IRV_Value"])) == pytest.approx(20.0, abs=0.3)
    assert [note for note in machine.notes if note.is_note and "through_zero_reference" in note.what]


def test_t20_an_axis_is_shown_by_its_position(tmp_path: Path) -> None:
    multiple = TASK.replace("CYCLES = 1", "NUMBER = 2; CYCLES = 1").replace("SEQ_A;", "SEQ_A[i];")
    machine = Machine(tmp_path, "AXI_A[i] <- absolute_move(12.5); PamDisplay <- AXI_A[i];", task=multiple).go(4.0)
    assert machine.rig.get("pam", "display") == "    12.5"


def test_t20_the_display_shows_an_expression_and_the_position_of_an_axis(tmp_path: Path) -> None:
    machine = Machine(tmp_path, "IRV_Value <- 1.5; PAMDISPLAY <- 2.0 * IRV_Value + (AXS_A ? position);").go(4.0)
    assert machine.rig.get("pam", "display") == "       3"


def test_t22_a_status_is_asked_by_its_mask(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path, "AXS_A <- power_off; CONDITION AXI_A[all*] ? status(POWER_OFF); IWV_Code <- AXS_A ? status;"
    ).go()
    assert machine["IWV_Step"] == 9
    assert int(str(machine["IWV_Code"])) & 16
