"""An application of the PAM moves two ST1 over the ring: moves, a pipe, a superimposed move, a register, an output."""

from pathlib import Path

import pytest

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_devices.pamring.axis_words import Status

DEGREE = 1 / 360
APPLICATION = """
APPLICATION NAME = Two V1.00; BASIC_PAM_CYCLE = 3; END
NODE NOD_A; ADDRESS = 1; TYPE = ST1; END
NODE NOD_B; ADDRESS = 2; TYPE = ST1; END
AXIS AXI_A; NODE = NOD_A; PULSES_PER_UNIT = 11930464.71111111; TRAVEL_SPEED = 3600.0; ACCELERATION = 36000.0;
  INITIAL_POSITION = 10.0; POSITION_PERIOD = 360.0; END
AXIS AXI_B; NODE = NOD_B; PULSES_PER_UNIT = -11930464.71111111; TRAVEL_SPEED = 3600.0; ACCELERATION = 36000.0;
  INITIAL_POSITION = 0.0; POSITION_RANGE = 0.0 1000.0; END
ENCODER ENC_A; NODE = NOD_A; ADDRESS = 0; PULSES_PER_UNIT = 182.04444444444444; POSITION_PERIOD = 360.0; END
BINARY_OUTPUT SBO_Moved; NODE = NOD_A; ADDRESS = 201; ACTIVE = HIGH; END
BINARY_OUTPUT SBO_Right; NODE = NOD_B; ADDRESS = 208; ACTIVE = LOW; END
TMP_GENERATOR TMP_G; TRAVEL_SPEED = 720.0; ACCELERATION = 7200.0; INITIAL_POSITION = 0.0; POSITION_PERIOD = 360.0;
  PERIOD = 0.001; END
CONVERTER CNV_A; DESTINATION = AXI_A; MODE = POSITION; END
TASK TSK_T; SPECS CYCLES = 1; END_SPECS
SEQUENCE SEQ_S;
  AXI_A <- power_on; AXI_B <- power_on;
  CONDITION AXI_A ? ready * AXI_B ? ready;
  AXI_A <- absolute_move(90.0); AXI_B <- absolute_move(180.0);
  CONDITION AXI_A ? ready * AXI_B ? ready;
  SBO_Moved <- set;
  AXI_A <- position(0.0);
  CNV_A << TMP_G;
  CONDITION CNV_A ? ready;
  TMP_G <- run(720.0);
  WAIT_TIME 500;
  AXI_A <- relative_move(45.0);
  WAIT_TIME 500;
  TMP_G <- absolute_move(0.0);
  CONDITION TMP_G ? ready;
  WAIT_TIME 20;
  CNV_A <- disactivate;
  WAIT_TIME 20;
  AXI_A <- power_off;
  CONDITION AXI_A ? ready;
  IF ENC_A ? value > 134.99 THEN IF ENC_A ? value < 135.01 THEN SBO_Right <- set; END_IF END_IF
END_SEQUENCE
POWERON XEQ_SEQUENCE SEQ_S; END_POWERON
END_TASK
"""


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    (tmp_path / "two.pam").write_text(APPLICATION, encoding="utf-8")
    links = {"ring": "ring0"}
    devices = {
        "pam": {"kind": "pam", "application": "two.pam", "links": links},
        "a": {"kind": "st1", "ring_address": 1, "links": links},
        "b": {"kind": "st1", "ring_address": 2, "links": links},
    }
    return Rig(
        from_dict({"time": "virtual", "buses": {"ring0": {"kind": "pamring.virtual"}}, "devices": devices}, tmp_path)
    )


@pytest.mark.long
@pytest.mark.manual("PAML-040", "PAML-042", "PAML-045", "PAML-046")
def test_an_application_moves_its_axes(rig: Rig) -> None:
    while not rig.get("a", "OUT8"):
        rig.run_until(rig.now_ns + MS)
    assert float(rig.get("a", "motor")) == pytest.approx(90 * DEGREE)
    assert float(rig.get("b", "motor")) == pytest.approx(-180 * DEGREE)
    assert rig.get("b", "OUT15") is True  # inactive
    rig.run_until(rig.now_ns + 400 * MS)
    assert rig.get("a", "status") == Status.SYNCHRONISED
    assert float(rig.get("a", "speed")) == pytest.approx(2.0)
    fastest = 0.0
    while rig.get("b", "OUT15"):
        rig.run_until(rig.now_ns + MS)
        fastest = max(fastest, float(rig.get("a", "speed")))
    assert fastest == pytest.approx(2.0 + 3.5355, abs=0.1)  # 45 degrees with 36000 degrees/s2: a triangle
    assert float(rig.get("a", "position")) == pytest.approx(45 * DEGREE)
    assert (rig.get("a", "status"), rig.get("a", "error")) == (Status.POWER_OFF | Status.STOPPED, 0)
