"""Random pipes of a PAM and what programs do with them, for tests that compare two forms of the same machine."""

import contextlib
from collections.abc import Callable
from typing import Any

from hypothesis import strategies as st
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.pam.pipes.shapes import shape_of

STRAIGHT = b"0 0\n1 1\n"
MACHINE = (
    HEADER
    + """
NODE NOD_A; ADDRESS = 1; TYPE = ST1; END
NODE NOD_B; ADDRESS = 2; TYPE = ST1; END
NODE NOD_C; ADDRESS = 3; TYPE = ST1; END
NODE NOD_Desk; ADDRESS = 17; TYPE = SMART_IO; END
BINARY_INPUT SBI_Mark; NODE = NOD_Desk; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
AXIS AXI_A; NODE = NOD_A; PULSES_PER_UNIT = 1000; TRAVEL_SPEED = 100; ACCELERATION = 1000; INITIAL_POSITION = 0;
  POSITION_PERIOD = 90; END
AXIS AXI_B; NODE = NOD_B; PULSES_PER_UNIT = -100; TRAVEL_SPEED = 100; ACCELERATION = 1000; INITIAL_POSITION = 0;
  POSITION_RANGE = -1000 1000; END
AXIS AXI_C; NODE = NOD_C; PULSES_PER_UNIT = -100; TRAVEL_SPEED = 100; ACCELERATION = 1000; INITIAL_POSITION = 0;
  POSITION_RANGE = -1000 1000; END
AXES_SET AXS_BC; OPTIMIZE = YES; AXIS = AXI_B; AXIS = AXI_C SUBSET = 1; END
ROUTINES RGR_All; ROUTINE RTN_Up; END_ROUTINE ROUTINE RTN_Down; END_ROUTINE END_ROUTINES
SINK SNK_A; END
SINK SNK_B; END
PAM_ANALOG_OUTPUT PAO_A; UNITS_PER_VOLT = 10; OFFSET = 0; ADDRESS = 0; END
TMP_GENERATOR TMP_A; TRAVEL_SPEED = 10; ACCELERATION = 1000; INITIAL_POSITION = 0; POSITION_RANGE = -1000 1000;
  PERIOD = 0.001; END
TMP_GENERATOR TMP_B; TRAVEL_SPEED = 300; ACCELERATION = 3000; INITIAL_POSITION = 30; POSITION_PERIOD = 90;
  PERIOD = 0.003; ANTI_DELAY = NO; END
PMP_GENERATOR PMP_A; FIRST_TRAVEL_SPEED = 100; LAST_TRAVEL_SPEED = 50; ACCELERATION = 10000; JERK = 1000000;
  INITIAL_POSITION = 0; POSITION_RANGE = -1000 1000; PERIOD = 0.002; END
SAMPLER SAM_A; SOURCE = AXI_A; MODE = POSITION; PERIOD = 0.001; END
AMPLIFIER AMP_A; GAIN = 2; OFFSET = 5; GAIN_SLOPE = 100; OFFSET_SLOPE = MAX; END
AMPLIFIER AMP_B; GAIN = -1; OFFSET = 0; GAIN_SLOPE = MAX; OFFSET_SLOPE = 1000; END
PROFILE PRO_A; FILE = FEED; INPUT_AMPLITUDE = 90; OUTPUT_AMPLITUDE = 100; INPUT_OFFSET = 0; OUTPUT_OFFSET = 10; END
CAM CAM_A; PROFILE = PRO_A; VALUE_PERIOD = 90; END
COMPARATOR CMP_A; REFERENCE = 7; ROUTINE = RTN_Up; REVERSE_ROUTINE = RTN_Down; END
CORRECTOR COR_A; CORRECTION_SLOPE = 3600; CORRECTION_LEVEL = 360; CORRECTION_REFERENCE = OUTPUT;
  CORRECTION_MODE = ON_REQUEST; TRIGGER_MODE = ONCE; TRIGGER_INPUT = SBI_Mark; DELAY_COMPENSATION = 0.00; END
CORRECTOR COR_B; CORRECTION_SLOPE = 100; CORRECTION_LEVEL = 1000; CORRECTION_REFERENCE = INPUT;
  CORRECTION_MODE = IMMEDIATE; TRIGGER_MODE = REPETITIVE; TRIGGER_INPUT = SBI_Mark; VALUE_PERIOD = 90;
  DELAY_COMPENSATION = 0.01; END
DERIVATOR DER_A; VALUE_PERIOD = 90; END
DISTRIBUTOR DIS_A; DIVISOR = 3; SHIFT = 1; END
PHASER PHA_A; PHASE = 10; PHASE_SLOPE = 1000; STANDBY_VALUE = 40; VALUE_PERIOD = 90; END
MULTI_COMPARATOR MUL_A; TIME_ORIGIN_SLOPE = POSITIVE; TIME_ORIGIN_COMPARE_MODE = IMMEDIATE;
  TIME_ORIGIN_REFERENCE = 20; TIME_ORIGIN_ROUTINE = RTN_Up; VALUE_PERIOD = 90;
  TRACE TRC_A; ROUTINE = RTN_Down; END
END
CONVERTER CNV_Sink; DESTINATION = SNK_A; MODE = VALUE; END
CONVERTER CNV_Other; DESTINATION = SNK_B; MODE = POSITION; END
CONVERTER CNV_Volts; DESTINATION = PAO_A; MODE = VALUE; END
CONVERTER CNV_Axis; DESTINATION = AXI_A; MODE = POSITION; END
CONVERTER CNV_Speed; DESTINATION = AXI_A; MODE = SPEED; END
CONVERTER CNV_Torque; DESTINATION = AXI_A; MODE = TORQUE; END
CONVERTER CNV_Single; DESTINATION = AXI_B; MODE = POSITION; END
CONVERTER CNV_Set; DESTINATION = AXS_BC; MODE = POSITION; END
"""
)
SOURCES = ("TMP_A", "TMP_B", "PMP_A", "SAM_A")
TRANSFORMERS = ("AMP_A", "AMP_B", "CAM_A", "CMP_A", "COR_A", "COR_B", "DER_A", "DIS_A", "PHA_A", "MUL_A")
CONVERTERS = ("CNV_Sink", "CNV_Other", "CNV_Volts", "CNV_Axis", "CNV_Speed", "CNV_Torque", "CNV_Single", "CNV_Set")
QUESTIONS = {
    "TMP": "ready position speed acceleration",
    "PMP": "ready position speed acceleration",
    "SAM": "value",
    "COR": "ready value triggered correction latched_value latched_d_value latched_dd_value",
    "MUL": "ready value execute",
    "CNV": "ready",
    "AXI": "ready position speed generator_position pipe_motionless",
    "AXS": "ready position speed generator_position pipe_motionless",
}

Action = Callable[[Bench], object]
"""An action of a program, or an event of the machine."""

numbers = st.sampled_from([0.0, -0.0, 1.0, -1.0, 2.0, 7.0, 10.0, 20.0, 30.0, 45.0, 89.0, 90.0, 180.0, -3.5, 0.1, 1e-9])


class Do:
    """A call of an executive function."""

    def __init__(self, name: str, function: str, *arguments: Any) -> None:
        self._name, self._function, self._arguments = name, function, arguments

    def __repr__(self) -> str:
        return f"{self._name} <- {self._function}{self._arguments}"

    def __call__(self, bench: Bench) -> None:
        bench.do(self._name, self._function, *self._arguments)


class Put(Do):
    """An assignment to a parameter, or to the object itself."""

    def __init__(self, path: str, value: Any) -> None:
        name, _, parameter = path.partition(".")
        super().__init__(name, parameter, value)

    def __call__(self, bench: Bench) -> None:
        if self._function:
            bench.item(self._name).set_parameter(self._function, *self._arguments)
        else:
            bench.item(self._name).set_value(*self._arguments)


class Axes(Do):
    """A function of a converter whose first argument is an axis."""

    def __call__(self, bench: Bench) -> None:
        axis, *others = self._arguments
        bench.do(self._name, self._function, bench.item(axis), *others)


class Connect:
    def __init__(self, names: list[str]) -> None:
        self._names = names

    def __repr__(self) -> str:
        return " << ".join(self._names)

    def __call__(self, bench: Bench) -> None:
        bench.connect(*self._names)


class TakeProfile:
    """The cam takes its profile over again, with what programs have changed in it."""

    def __repr__(self) -> str:
        return "CAM_A ~ PRO_A"

    def __call__(self, bench: Bench) -> None:
        bench.item("CAM_A").set_parameter("PROFILE", bench.item("PRO_A"))


class Mark:
    """The trigger input of the correctors rises and falls."""

    def __init__(self, age_us: int) -> None:
        self._age_us = age_us

    def __repr__(self) -> str:
        return f"mark({self._age_us})"

    def __call__(self, bench: Bench) -> None:
        bench.change(17, 1, 1, self._age_us)
        bench.change(17, 1, 0)


PARAMETERS = """
    AMP_A.GAIN AMP_A.OFFSET AMP_A.GAIN_SLOPE AMP_B.GAIN AMP_B.OFFSET AMP_B.OFFSET_SLOPE PHA_A.PHASE PHA_A.PHASE_SLOPE
    PHA_A.STANDBY_VALUE CMP_A.REFERENCE CMP_A.THROUGH_ZERO_REFERENCE COR_A.CORRECTION_LEVEL PRO_A.OUTPUT_OFFSET
    CAM_A.VALUE_PERIOD DER_A.VALUE_PERIOD TMP_B.POSITION_PERIOD PHA_A.VALUE_PERIOD MUL_A.VALUE_PERIOD PAO_A
    TMP_A.TRAVEL_SPEED TMP_A.ACCELERATION MUL_A.TIME_ORIGIN_REFERENCE
"""
parameters = st.sampled_from(PARAMETERS.split())
slopes = st.sampled_from(["POSITIVE", "NEGATIVE", "ZERO_MAXIMUM", "ZERO_MINIMUM"])
pipes = st.builds(
    lambda converter, transformers, source: Connect([converter, *transformers, source]),
    st.sampled_from(CONVERTERS),
    st.lists(st.sampled_from(TRANSFORMERS), max_size=4, unique=True),
    st.sampled_from(SOURCES),
)
moves = st.builds(
    Do,
    st.sampled_from(["TMP_A", "TMP_B", "PMP_A"]),
    st.sampled_from(["absolute_move", "relative_move", "run", "position"]),
    numbers,
)
actions: st.SearchStrategy[Action] = st.one_of(
    pipes,
    moves,
    moves,
    st.builds(Put, parameters, numbers),
    st.builds(Do, st.sampled_from(["COR_A", "COR_B"]), st.just("trigger"), numbers),
    st.builds(Do, st.sampled_from(["COR_A", "COR_B"]), st.sampled_from(["trigger_off", "start_correction"])),
    st.builds(Mark, st.sampled_from([0, 500, 4000])),
    st.builds(Do, st.just("PHA_A"), st.sampled_from(["start", "stop"])),
    st.builds(Do, st.just("MUL_A"), st.sampled_from(["learn", "execute"])),
    st.builds(
        Do,
        st.just("TRC_A"),
        st.just("install_reference"),
        slopes,
        st.sampled_from(["IMMEDIATE", "NEXT_PERIOD"]),
        numbers,
        st.sampled_from([0.0, 0.01]),
    ),
    st.builds(TakeProfile),
    st.builds(Do, st.sampled_from(["AXI_A", "AXI_B", "AXS_BC"]), st.sampled_from(["stop", "power_on"])),
    st.builds(Do, st.sampled_from(["AXI_A", "AXI_B"]), st.sampled_from(["relative_move", "position"]), numbers),
    st.builds(Do, st.sampled_from(CONVERTERS), st.just("deactivate")),
    st.builds(
        Axes, st.just("CNV_Set"), st.sampled_from(["connect", "disconnect"]), st.sampled_from(["AXI_B", "AXI_C"])
    ),
    st.builds(Axes, st.just("CNV_Set"), st.just("change_ratio"), st.sampled_from(["AXI_B", "AXI_C"]), numbers),
)
scripts = st.lists(st.tuples(actions, st.integers(0, 60)), min_size=1, max_size=20)
"""Actions, each with the cycles after it."""


class Machine(Bench):
    """The machine of these pipes; `shown` is all that programs and nodes can see."""

    def __init__(self) -> None:
        self.volts: list[tuple[int, float]] = []
        super().__init__(
            MACHINE, shapes=lambda _name: shape_of(STRAIGHT), volts=lambda *volts: self.volts.append(volts)
        )
        self.st1(1, 2, 3)
        self._seen = 0
        self._names = [name for name in self.objects.items if name[:3] in QUESTIONS or name in TRANSFORMERS]

    def shown(self) -> str:
        """Return the answers of all objects, and what has been sent, started and reported since the last call."""
        kernel = self.kernel
        answers = [
            self.ask(name, question)
            for name in self._names
            for question in QUESTIONS.get(name[:3], "ready value").split()
        ]
        gains = [self.item(path[:5]).parameter(path[6:]) for path in ("AMP_A.GAIN", "AMP_B.OFFSET", "PHA_A.PHASE")]
        sent, self._seen = self.port.sent[self._seen :], len(self.port.sent)
        news = (sent, self.volts, kernel.routines, kernel.reports, sorted(kernel.touched_names))
        shown = repr((answers, gains, news))
        for kept in (self.volts, kernel.routines, kernel.reports, kernel.touched_names):
            kept.clear()
        return shown

    def play(self, script: list[tuple[Action, int]]) -> list[str]:
        """Return what is shown in each cycle of a script."""
        shown = []
        for action, cycles in script:
            with contextlib.suppress(ArithmeticError):  # a move of the generator that no number can hold
                action(self)
            for _ in range(cycles):
                self.cycle()
                shown.append(self.shown())
        return shown
