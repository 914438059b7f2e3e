"""A machine for one case of section 19 of the digest: a PAM, two axes and a Smart-IO, and a sequence of statements."""

from pathlib import Path

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.rig_file import rig_file

HEADER = """
#include "ST1ERROR.SYS"
APPLICATION NAME = accept V1.00; BASIC_PAM_CYCLE = 3; END
NODE NOD_A; NUMBER = 2; ADDRESS = 1; TYPE = ST1; END
NODE NOD_Io; ADDRESS = 33; TYPE = SMART_IO; END
AXIS AXI_A; NODE = NOD_A; PULSES_PER_UNIT = 11930464.71111111; TRAVEL_SPEED = 360.0; ACCELERATION = 3600.0;
  INITIAL_POSITION = 0.0; POSITION_RANGE = -1000000.0 1000000.0; END
AXES_SET AXS_A; AXIS = AXI_A[all]; END
LED_OUTPUT LED_A; NODE = NOD_Io; ADDRESS = 1; END
INTERNAL FLAG_VAR IFV_Begin;
INTERNAL FLAG_VAR IFV_Go;
INTERNAL FLAG_VAR IFV_Seen;
INTERNAL REAL_VAR IRV_Value;
INTERNAL REAL_VAR IRV_Target; NUMBER = 2; END
INTERNAL WORD_VAR IWV_Step;
INTERNAL WORD_VAR IWV_Code;
TMP_GENERATOR TMP_A; TRAVEL_SPEED = 100.0; ACCELERATION = 1000.0; INITIAL_POSITION = 0.0;
  POSITION_RANGE = -1000000.0 1000000.0; PERIOD = 0.001; ANTI_DELAY = NO; END
"""
TASK = """
TASK TSK_A; SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IFV_Begin XEQ_SEQUENCE SEQ_A; END_EVENTS
  SEQUENCE SEQ_A;
    AXS_A <- power_on;
    CONDITION AXS_A ? ready;
    IWV_Step <- 1;
    CONDITION IFV_Go;
    {body}
    IWV_Step <- 9;
  END_SEQUENCE
  POWERON IFV_Begin <- set; END_POWERON
END_TASK
"""


class Machine:
    """An application on its ring.  `go` lets its sequence go on behind its first condition."""

    def __init__(
        self, folder: Path, body: str, declarations: str = "", task: str = TASK, keys: str = "", line: str = ""
    ) -> None:
        """`keys` are further lines of the PAM in the rig file, and `line` the settings of a bus for its RS422 port."""
        text = HEADER + declarations + task.replace("{body}", body)
        program, self.notes = checked(text, "accept.pam")
        assert not [str(note) for note in self.notes if not note.is_note]
        (folder / "accept.pam").write_text(text)
        rig = rig_file(program, "accept.pam", is_virtual=True).replace("accept.pam\n  nod", f"accept.pam\n{keys}  nod")
        if line:
            rig = rig.replace("wires: wires}\n    app", "wires: wires, rs422: line}\n    app")
            rig = rig.replace("buses:\n", f"buses:\n  line: {line}\n")
        (folder / "rig.yaml").write_text(rig)
        self.rig = Rig(load(folder / "rig.yaml"))
        self.until("IWV_Step", 1)

    def __getitem__(self, name: str) -> object:
        return self.rig.get("pam", name)

    def __setitem__(self, name: str, value: bool | float) -> None:
        self.rig.set("pam", name, value)

    def go(self, seconds: float = 2.0) -> "Machine":
        self["IFV_Go"] = True
        self.wait(seconds)
        return self

    def wait(self, seconds: float) -> None:
        self.rig.run_until(self.rig.now_ns + round(seconds * S))

    def until(self, name: str, value: object, seconds: float = 10.0) -> float:
        """Wait until a variable has a value; return the seconds that it took."""
        begin_ns = self.rig.now_ns
        while self[name] != value:
            assert self.rig.now_ns < begin_ns + seconds * S, (name, self[name], self.rig.get("pam", "messages"))
            self.rig.run_until(self.rig.now_ns + MS)
        return (self.rig.now_ns - begin_ns) / S

    def degrees(self, number: int = 1, *, of: str = "set_position") -> float:
        return float(self.rig.get(f"nod_a_{number}", of)) * 360
