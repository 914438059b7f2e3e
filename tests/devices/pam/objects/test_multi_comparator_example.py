"""The multi-comparator of manual lines 5792 to 5898, in a PAM without nodes."""

from pathlib import Path

import pytest
from pam_rigs import pam_rig

from fieldrig.clock import S
from fieldrig.pytest_plugin import RigMaker

pytestmark = pytest.mark.long

APPLICATION = """APPLICATION NAME = multi V1.00; BASIC_PAM_CYCLE = 3; END
SINK SNK_a; END
CONVERTER CNV_a; DESTINATION = SNK_a; MODE = VALUE; END
TMP_GENERATOR TMP_a; TRAVEL_SPEED = 10; ACCELERATION = 100; INITIAL_POSITION = 0; POSITION_PERIOD = 1.0;
  PERIOD = 0.001; ANTI_DELAY = NO; END
COMMON WORD_VAR CWV_One;
COMMON WORD_VAR CWV_Two;
COMMON FLAG_VAR CFV_Done;
INTERNAL FLAG_VAR IFV_Go;
ROUTINES RGR_a;
  ROUTINE RTN_Origin; PAMDISPLAY <- message(1, "origin", TMP_a ? position); END_ROUTINE
END_ROUTINES
MULTI_COMPARATOR MUL_a; TIME_ORIGIN_SLOPE = POSITIVE;
  TIME_ORIGIN_COMPARE_MODE = NEXT_PERIOD; TIME_ORIGIN_REFERENCE = 0.05;
  TIME_ORIGIN_ROUTINE = RTN_Origin; VALUE_PERIOD = 1.0;
  TRACE TRC_1; ROUTINE = NONE; END
  TRACE TRC_2; ROUTINE = NONE; END
END
ROUTINES RGR_b;
  ROUTINE RTN_1;
    IF CWV_One = 1 THEN
      CWV_One <- 2; PAMDISPLAY <- message(3, "one first", MUL_a ? value);
      TRC_1 <- install_reference(POSITIVE, IMMEDIATE, 0.4, 0.005);
    ELSE
      CWV_One <- 1; PAMDISPLAY <- message(3, "one second", MUL_a ? value);
    END_IF
  END_ROUTINE
  ROUTINE RTN_2;
    IF CWV_Two = 1 THEN
      CWV_Two <- 2; PAMDISPLAY <- message(4, "two first", MUL_a ? value);
      TRC_2 <- install_reference(POSITIVE, IMMEDIATE, 0.4, 0.005);
    ELSE
      CWV_Two <- 1; CFV_Done <- 1; PAMDISPLAY <- message(4, "two second", MUL_a ? value);
    END_IF
  END_ROUTINE
END_ROUTINES
TASK TSK_a;
  SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE SEQ_a; END_EVENTS
  SEQUENCE SEQ_a;
    CFV_Done <- 0; CWV_One <- 1; CWV_Two <- 1;
    TRC_1:ROUTINE <- RTN_1; TRC_2:ROUTINE <- RTN_2;
    MUL_a <- learn;
    CNV_a << MUL_a << TMP_a;
    CONDITION CNV_a ? ready;
    TRC_1 <- install_reference(POSITIVE, IMMEDIATE, 0.2, 0.010);
    TRC_2 <- install_reference(POSITIVE, NEXT_PERIOD, 0.2, 0.010);
    TMP_a <- run(1.0);
    LOOP
      CONDITION CFV_Done = 1;
      MUL_a <- execute;
      CFV_Done <- 0;
      TRC_1 <- install_reference(POSITIVE, IMMEDIATE, 0.2, 0.010);
      TRC_2 <- install_reference(POSITIVE, NEXT_PERIOD, 0.2, 0.010);
    END_LOOP !IFV_Go;
  END_SEQUENCE
  POWERON IFV_Go <- set; END_POWERON
END_TASK
"""


@pytest.mark.manual("PAML-551")
@pytest.mark.manual("PAML-557")
@pytest.mark.manual("PAML-558")
@pytest.mark.manual("PAML-273")
def test_the_example_of_the_manual_learns_and_then_is_earlier(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    rig = pam_rig(fieldrig_rig, tmp_path, APPLICATION)
    rig.run_until(5 * S)
    lines = [
        line.split()[1:] for line in str(rig.get("pam", "messages")).splitlines() if line.startswith("application")
    ]
    cycle = ["origin", "one first", "one second", "two first", "two second"]
    assert [" ".join(words) for *words, _ in lines] == [*cycle, *cycle]
    places = [float(place) for *_, place in lines]
    learned, executed = [0.05, 0.2, 0.4, 0.2, 0.4], [0.05, 0.19, 0.395, 0.19, 0.395]  # 10 and 5 ms earlier
    assert places == pytest.approx([*learned, *executed], abs=0.0021)
