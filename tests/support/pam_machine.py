"""A large machine on a PAM: 16 axes in 8 pipes of 5 blocks, 4 tasks, and 6 Smart-IO nodes wired to each other."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

PIPES = 8
"""Each moves an axes set of two axes."""
DESKS = 6
"""Smart-IO nodes."""
FIRST_DESK = 41

PIPE = """
NODE NOD_{n}; NUMBER = 2; ADDRESS = {address}; TYPE = ST1; END
AXIS AXI_{n}; NODE = NOD_{n}; PULSES_PER_UNIT = 11930464.7111; TRAVEL_SPEED = 360; ACCELERATION = 3600;
  INITIAL_POSITION = 0; POSITION_PERIOD = 360; END
AXES_SET AXS_{n}; OPTIMIZE = {optimize}; AXIS = AXI_{n}[all]; END
AMPLIFIER AMP_{n}; GAIN = 1; OFFSET = {n}; GAIN_SLOPE = MAX; OFFSET_SLOPE = MAX; END
COMPARATOR CMP_{n}; REFERENCE = 180; END
PHASER PHA_{n}; PHASE = {n}; PHASE_SLOPE = 10; STANDBY_VALUE = 0; VALUE_PERIOD = 360; END
CONVERTER CNV_{n}; DESTINATION = AXS_{n}; MODE = POSITION; END
TMP_GENERATOR TMP_{n}; TRAVEL_SPEED = 360; ACCELERATION = 3600; INITIAL_POSITION = 0; POSITION_PERIOD = 360;
  PERIOD = 0.001; END
"""
DESK = """
NODE NOD_Desk{n}; ADDRESS = {address}; TYPE = SMART_IO; END
BINARY_INPUT SBI_{n}; NODE = NOD_Desk{n}; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
BINARY_OUTPUT SBO_{n}; NODE = NOD_Desk{n}; ADDRESS = 101; ACTIVE = HIGH; END
DIGITAL_INPUT SDI_{n}; NODE = NOD_Desk{n}; BITS = 6; ADDRESS = 103; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
DIGITAL_OUTPUT SDO_{n}; NODE = NOD_Desk{n}; BITS = 6; ADDRESS = 103; ACTIVE = HIGH; END
"""
TASKS = """
INTERNAL FLAG_VAR IFV_Go; INTERNAL FLAG_VAR IFV_Moving; INTERNAL FLAG_VAR IFV_Alarm;
INTERNAL WORD_VAR IWV_Edges; INTERNAL WORD_VAR IWV_Code; INTERNAL WORD_VAR IWV_Sum; INTERNAL WORD_VAR IWV_Rounds;
INTERNAL REAL_VAR IRV_Level; INTERNAL REAL_VAR IRV_Speed;

// Moves: all axes begin to run, and then the speed of each pipe changes five times a second.
TASK TSK_Moves;
  SPECS CYCLES = 5; END_SPECS
  EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE SEQ_Begin; END_EVENTS
  SEQUENCE SEQ_Begin;
    {power_on}
    CONDITION {powered};
    {connect}
    {phasers}
    IFV_Moving <- set;
    LOOP
      IRV_Speed <- 300.0; {run}
      WAIT_TIME 200;
      IRV_Speed <- 200.0; {run}
      WAIT_TIME 200;
    END_LOOP !IFV_Go;
  END_SEQUENCE
END_TASK

// Calculates: a filter and a limit in every basic cycle.
TASK TSK_Calculates;
  SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE SEQ_Filter; END_EVENTS
  SEQUENCE SEQ_Filter;
    LOOP
      IRV_Level <- IRV_Level + ((TMP_0 ? position) - IRV_Level) * 0.125;
      IFV_Alarm <- (IRV_Level > 350.0) * IFV_Moving;
      IF IFV_Alarm THEN IRV_Level <- 0.0; END_IF
      IWV_Rounds <- IWV_Rounds + 1;
      IF IWV_Rounds >= 10000 THEN IWV_Rounds <- 0; END_IF
      WAIT_TIME 1;
    END_LOOP !IFV_Go;
  END_SEQUENCE
END_TASK

// Outputs: every 10 ms, a node has a new level and a new code at its outputs.
TASK TSK_Outputs;
  SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE SEQ_Toggle; END_EVENTS
  SEQUENCE SEQ_Toggle;
    LOOP
      {outputs}
      IWV_Code <- IWV_Code + 1;
      IF IWV_Code > 63 THEN IWV_Code <- 0; END_IF
    END_LOOP !IFV_Go;
  END_SEQUENCE
END_TASK

// Inputs: every edge is counted, and the codes are added up every 20 ms.
TASK TSK_Inputs;
  SPECS CYCLES = 1; END_SPECS
  EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE SEQ_Sum; END_EVENTS
  SEQUENCE SEQ_Sum;
    LOOP
      IWV_Sum <- {codes};
      WAIT_TIME 20;
    END_LOOP !IFV_Go;
  END_SEQUENCE
  {power}
END_TASK
ACTIONS ACT_Edges;
  SPECS CYCLES = 1; END_SPECS
  {edges}
END_ACTIONS
"""
EDGE = """ON_EVENT SBI_{n} ACTION
    IWV_Edges <- IWV_Edges + 1;
    IF IWV_Edges >= 10000 THEN IWV_Edges <- 0; END_IF
  END_ACTION"""


def pipes_text(*, optimizes: bool = False) -> str:
    """Return the application with nothing but axes and pipes."""
    head = "APPLICATION NAME = pipes V1.00; BASIC_PAM_CYCLE = 3; END\n"
    word = "YES" if optimizes else "NO"
    return head + "".join(PIPE.format(n=n, address=2 * n + 1, optimize=word) for n in range(PIPES))


def application_text(*, optimizes: bool = True, is_idle: bool = False) -> str:
    """Return the whole application; an idle one waits for `IFV_Go`, without a pipe."""
    tasks = TASKS.format(
        power_on=" ".join(f"AXS_{n} <- power_on;" for n in range(PIPES)),
        powered=" * ".join(f"(AXS_{n} ? ready)" for n in range(PIPES)),
        connect=" ".join(f"CNV_{n} << PHA_{n} << CMP_{n} << AMP_{n} << TMP_{n};" for n in range(PIPES)),
        phasers=" ".join(f"PHA_{n} <- start;" for n in range(PIPES)),
        run=" ".join(f"TMP_{n} <- run(IRV_Speed + {n}.0);" for n in range(PIPES)),
        outputs=" ".join(f"SBO_{n} <- invert; SDO_{n} <- IWV_Code; WAIT_TIME 10;" for n in range(DESKS)),
        codes=" + ".join(f"SDI_{n}" for n in range(DESKS)),
        edges="\n  ".join(EDGE.format(n=n) for n in range(DESKS)),
        power="" if is_idle else "POWERON IFV_Go <- set; END_POWERON",
    )
    desks = "".join(DESK.format(n=n, address=FIRST_DESK + n) for n in range(DESKS))
    return pipes_text(optimizes=optimizes) + desks + tasks


def rig_of(application: Path, time: Literal["virtual", "real"], **ring: Any) -> dict[str, Any]:
    """Return the rig; in real time every device has a process of its own.  `ring` are settings of the ring."""
    kinds = {"virtual": ("pamring.virtual", "wires.virtual"), "real": ("pamring.shm", "wires.hub")}[time]
    nodes = dict(_nodes())
    pam = {"kind": "pam", "application": str(application), "links": {"ring": "ring0"}, "after": list(nodes)}
    return {
        "time": time,
        "buses": {"ring0": {"kind": kinds[0], **ring}, "wires": {"kind": kinds[1]}},
        "devices": {"pam": pam, **nodes},
    }


def _nodes() -> Iterator[tuple[str, dict[str, Any]]]:
    links = {"ring": "ring0", "wires": "wires"}
    for address in range(1, 2 * PIPES + 1):
        yield f"axis{address}", {"kind": "st1", "ring_address": address, "links": links}
    for desk in range(DESKS):
        yield (
            f"desk{desk}",
            {
                "kind": "smart_io",
                "ring_address": FIRST_DESK + desk,
                "keyboard": "none",
                "links": links,
                "terminals": {**_wires("out", desk), **_wires("in", (desk - 1) % DESKS)},
            },
        )


def _wires(terminal: str, desk: int) -> dict[str, str]:
    """Return the wires from the outputs of a Smart-IO to the inputs of the next."""
    return {f"{terminal}{position}": f"desk{desk}.level{position}" for position in (101, *range(103, 109))}
