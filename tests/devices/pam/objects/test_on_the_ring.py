"""The objects of a PAM on its ring, with the servo node of this project: positions, instants and zeroing."""

from pathlib import Path

import pytest
from pam_rigs import pam_rig

from fieldrig.clock import MS, S
from fieldrig.pytest_plugin import RigMaker
from fieldrig.virtual.rig import Rig

pytestmark = pytest.mark.long

AXIS = """
  axis:
    {kind: st1, ring_address: 1, initial_turns: 0.3, parameters: {ckv: 50, cka: 800}, links: {ring: ring, wires: wires}}
"""
MACHINE = """APPLICATION NAME = whole V1.00; BASIC_PAM_CYCLE = 3; END
NODE NOD_Axis; ADDRESS = 1; TYPE = ST1; END
AXIS AXI_Axis; NODE = NOD_Axis; PULSES_PER_UNIT = 11930464.711111111; TRAVEL_SPEED = 720; ACCELERATION = 36000;
  DECELERATION = 72000; INITIAL_POSITION = 0; POSITION_PERIOD = 360; END
BINARY_INPUT SBI_Sensor; NODE = NOD_Axis; ADDRESS = 201; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
ENCODER ENC_Shaft; NODE = NOD_Axis; ADDRESS = 0; PULSES_PER_UNIT = 182.0444444444; POSITION_PERIOD = 360; END
TMP_GENERATOR TMP_Master; TRAVEL_SPEED = 360; ACCELERATION = 3600; INITIAL_POSITION = 0; POSITION_PERIOD = 360;
  PERIOD = 0.001; END
CONVERTER CNV_Axis; DESTINATION = AXI_Axis; MODE = POSITION; END
CORRECTOR COR_Mark; CORRECTION_MODE = ON_REQUEST; CORRECTION_REFERENCE = OUTPUT; CORRECTION_SLOPE = 3600;
  CORRECTION_LEVEL = 360; TRIGGER_MODE = ONCE; TRIGGER_INPUT = SBI_Sensor; DELAY_COMPENSATION = 0;
  VALUE_PERIOD = 360; END
INTERNAL WORD_VAR IWV_Begin;
"""
TASK = """TASK TSK_Run;
  SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IWV_Begin = 1 XEQ_SEQUENCE SEQ_Run; END_EVENTS
  SEQUENCE SEQ_Run;
    AXI_Axis <- power_on;
    CONDITION AXI_Axis ? ready;
    {statements}
  END_SEQUENCE
  POWERON IWV_Begin <- 1; END_POWERON
END_TASK
"""


def started(make: RigMaker, folder: Path, statements: str, objects: str = "", period: str = "0.001") -> Rig:
    machine = MACHINE.replace("PERIOD = 0.001", f"PERIOD = {period}") + objects
    rig = pam_rig(make, folder, machine + TASK.format(statements=statements), AXIS)
    while rig.get("pam", "state") != "running":
        rig.run_until(rig.now_ns + 10 * MS)
    return rig


def shown(rig: Rig, word: str) -> float:
    """The number behind a word in the last message that begins with it, once it is there."""
    for _ in range(500):
        found = [line for line in str(rig.get("pam", "messages")).splitlines() if f"application {word} " in line]
        if found:
            return float(found[-1].rpartition(" ")[2])
        rig.run_until(rig.now_ns + 10 * MS)
    raise AssertionError(f"no message {word}")


def degrees(rig: Rig) -> float:
    return float(rig.get("axis", "position")) * 360


@pytest.mark.manual("PAML-513")
@pytest.mark.manual("PAML-635")
@pytest.mark.parametrize("period", ["0.001", "0.005"])
def test_a_mark_is_latched_where_the_axis_was(fieldrig_rig: RigMaker, tmp_path: Path, period: str) -> None:
    rig = started(
        fieldrig_rig,
        tmp_path,
        """
    CNV_Axis << COR_Mark << TMP_Master;
    CONDITION CNV_Axis ? ready;
    TMP_Master <- run(360);
    COR_Mark <- trigger(0);
    CONDITION COR_Mark ? triggered;
    PAMDISPLAY <- message(1, "seen", COR_Mark ? latched_value);
    TMP_Master <- absolute_move(720);
    CONDITION TMP_Master ? ready;
    CONDITION AXI_Axis ? pipe_motionless;
    CNV_Axis <- disactivate;
    PAMDISPLAY <- message(2, "end", AXI_Axis ? position);
""",
        period=period,
    )
    rig.run_until(rig.now_ns + 500 * MS + 370_000)
    rig.set("axis", "IN16", True)
    was = degrees(rig)
    assert shown(rig, "seen") == pytest.approx(was, abs=0.02)  # 360 degrees/s: 0.36 degrees in a cycle
    assert shown(rig, "end") == pytest.approx(0, abs=1e-6)
    rig.run_until(rig.now_ns + S // 100)
    assert degrees(rig) % 360 == pytest.approx(0, abs=1e-6)


@pytest.mark.manual("PAML-208")
@pytest.mark.manual("PAML-144")
def test_an_axis_finds_its_zero(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    rig = started(
        fieldrig_rig,
        tmp_path,
        """
    ZEP_Axis <- start;
    CONDITION ZEP_Axis ? ready;
    PAMDISPLAY <- message(1, "shaft", ENC_Shaft);
    PAMDISPLAY <- message(2, "axis", AXI_Axis ? position);
""",
        "ZERO_POSITIONER ZEP_Axis; OBJECT = AXI_Axis; SENSOR = SBI_Sensor; COARSE_SPEED = 3600; COARSE_EDGE = RISING;"
        " COARSE_MOVE = 0.0; RESOLVER_OFFSET = 100; END\n",
    )
    rig.run_until(rig.now_ns + 300 * MS + 640_000)
    rig.set("axis", "IN16", True)
    assert shown(rig, "shaft") == pytest.approx(100, abs=0.01)
    assert shown(rig, "axis") == 0


def test_a_node_that_stands_still_while_its_optics_work_is_a_time_out_of_its_readings(
    fieldrig_rig: RigMaker, tmp_path: Path
) -> None:
    rig = started(
        fieldrig_rig,
        tmp_path,
        """
    CONDITION SBI_Sensor;
    AXI_Axis <- absolute_move(180);
    PAMDISPLAY <- message(1, "shaft", ENC_Shaft);
    CONDITION AXI_Axis ? ready;
    PAMDISPLAY <- message(2, "done", AXI_Axis ? position);
""",
    )
    rig.set("axis", "IN16", True)
    rig.run_until(rig.now_ns + MS)
    rig.add_fault("ring", {"what": "halt", "station": "axis"})
    shown(rig, "shaft")
    rig.run_until(rig.now_ns + 2 * S)
    assert rig.get("pam", "state") == "running"
    assert str(rig.get("pam", "messages")).count("E021") == 1
    assert "done" not in str(rig.get("pam", "messages"))
