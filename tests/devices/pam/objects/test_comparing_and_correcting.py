"""Comparators, multi-comparators and correctors in programs: routines, events with their instants, and states."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pam.runtime.item import RoutineRef

MACHINE = (
    HEADER
    + """
NODE NOD_Desk; ADDRESS = 17; TYPE = SMART_IO; END
BINARY_INPUT SBI_Mark; NODE = NOD_Desk; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
ROUTINES RGR_All;
  ROUTINE RTN_Up WITH IWV_a; END_ROUTINE
  ROUTINE RTN_Down; END_ROUTINE
  ROUTINE RTN_Origin; END_ROUTINE
END_ROUTINES
SINK SNK_Values; END
CONVERTER CNV_Values; DESTINATION = SNK_Values; MODE = VALUE; END
TMP_GENERATOR TMP_Belt; TRAVEL_SPEED = 1000; ACCELERATION = 1000000; INITIAL_POSITION = 0; POSITION_PERIOD = 500;
  PERIOD = 0.001; ANTI_DELAY = NO; END
COMPARATOR CMP_Full; REFERENCE = 180; ROUTINE = RTN_Up WITH -7; REVERSE_ROUTINE = NONE; END
MULTI_COMPARATOR MUL_Doors; TIME_ORIGIN_SLOPE = POSITIVE; TIME_ORIGIN_COMPARE_MODE = IMMEDIATE;
  TIME_ORIGIN_REFERENCE = 50; TIME_ORIGIN_ROUTINE = RTN_Origin; VALUE_PERIOD = 500;
  TRACE TRC_One; ROUTINE = NONE; END
  TRACE TRC_Two; ROUTINE = RTN_Up WITH 2; END
END
CORRECTOR COR_Mark; CORRECTION_SLOPE = 3600; CORRECTION_LEVEL = 3600; CORRECTION_REFERENCE = OUTPUT;
  CORRECTION_MODE = ON_REQUEST; TRIGGER_MODE = ONCE; TRIGGER_INPUT = SBI_Mark; DELAY_COMPENSATION = 0.00; END
CORRECTOR COR_Always; CORRECTION_SLOPE = 360000; CORRECTION_LEVEL = 3600; CORRECTION_REFERENCE = INPUT;
  CORRECTION_MODE = IMMEDIATE; TRIGGER_MODE = REPETITIVE; TRIGGER_INPUT = SBI_Mark; VALUE_PERIOD = 500;
  DELAY_COMPENSATION = 0.01; END
"""
)


def running(*blocks: str, speed: float = 1000, **options: float) -> Bench:
    """A machine whose belt runs through these blocks; it begins at 1 in the next cycle."""
    bench = Bench(MACHINE, readings=ObjectReadings(**options))  # type: ignore[arg-type]
    bench.connect("CNV_Values", *blocks, "TMP_Belt")
    bench.cycle()
    if speed:
        bench.do("TMP_Belt", "run", speed)
    return bench


def mark(bench: Bench, age_us: int = 0) -> None:
    """Let the mark pass; the report arrives with the next cycle."""
    bench.change(17, 1, 1, age_us)
    bench.change(17, 1, 0)
    bench.cycle()


@pytest.mark.manual("PAML-460")
@pytest.mark.manual("PAML-468")
@pytest.mark.manual("PAML-464")
@pytest.mark.manual("PAML-466")
@pytest.mark.manual("PAML-276")
def test_a_comparator_starts_its_routines_in_the_cycle_of_the_crossing() -> None:
    bench = running("CMP_Full")
    bench.until(lambda: bool(bench.kernel.routines))
    assert bench.kernel.routines == [RoutineRef("RTN_Up", (-7,))]
    assert bench.ask("CMP_Full", "value") == pytest.approx(180, abs=1)
    assert bench.ask("CMP_Full", "ready")
    bench.item("CMP_Full").set_parameter("REVERSE_ROUTINE", RoutineRef("RTN_Down"))
    bench.item("CMP_Full").set_parameter("ROUTINE", RoutineRef(""))
    bench.cycle(1000)
    assert bench.kernel.routines[1:] == [RoutineRef("RTN_Down")] * 2


@pytest.mark.manual("PAML-467")
@pytest.mark.manual("PAML-462")
@pytest.mark.manual("PAML-463")
@pytest.mark.manual("PAMS-038")
def test_a_comparator_through_zero_waits_for_the_next_period() -> None:
    bench = running("CMP_Full")
    bench.until(lambda: bool(bench.ask("CMP_Full", "value") >= 400))
    bench.item("CMP_Full").set_parameter("THROUGH_ZERO_REFERENCE", 326)
    assert not bench.ask("CMP_Full", "ready")
    assert bench.until(lambda: bool(bench.ask("CMP_Full", "ready"))) == pytest.approx(426, abs=2)
    bench.item("CMP_Full").set_parameter("REFERENCE", 400)
    assert not bench.ask("CMP_Full", "ready")
    assert bench.item("CMP_Full").parameter("REFERENCE") == 400


def test_a_reference_is_compared_also_while_the_pipe_rests() -> None:
    bench = running("CMP_Full", speed=0)
    bench.cycle(50)
    bench.item("CMP_Full").set_parameter("REFERENCE", -1)
    assert bench.ask("CMP_Full", "ready")
    assert bench.kernel.routines == [RoutineRef("RTN_Up", (-7,))]


@pytest.mark.manual("PAML-550")
@pytest.mark.manual("PAML-561")
@pytest.mark.manual("PAML-562")
@pytest.mark.manual("PAMS-024")
def test_a_multi_comparator_learns_and_executes() -> None:
    bench = Bench(MACHINE)
    bench.do("MUL_Doors", "learn")
    bench.connect("CNV_Values", "MUL_Doors", "TMP_Belt")
    bench.item("TRC_One").set_parameter("ROUTINE", RoutineRef("RTN_Down", (3,)))
    one, two = RoutineRef("RTN_Down", (3,)), RoutineRef("RTN_Up", (2,))
    places: dict[str, list[float]] = {}
    bench.cycle()
    bench.do("TMP_Belt", "run", 1000)
    for _ in range(2):
        assert bench.ask("MUL_Doors", "execute") is bool(places)
        bench.do("TRC_One", "install_reference", "POSITIVE", "IMMEDIATE", 100, 0.010)
        bench.do("TRC_Two", "install_reference", "POSITIVE", "NEXT_PERIOD", 100, 0)
        bench.kernel.routines.clear()
        for _ in range(1200):
            count = len(bench.kernel.routines)
            bench.cycle()
            for routine in bench.kernel.routines[count:]:
                places.setdefault(routine.routine, []).append(bench.ask("MUL_Doors", "value"))
        assert bench.kernel.routines == [RoutineRef("RTN_Origin"), one, two]
        bench.do("MUL_Doors", "execute")
    assert places["RTN_Origin"] == pytest.approx([50, 50], abs=1)
    assert places["RTN_Down"] == pytest.approx([100, 90], abs=1)  # 10 ms earlier than learned
    assert places["RTN_Up"] == pytest.approx([100, 100], abs=1)


@pytest.mark.manual("PAML-502")
@pytest.mark.manual("PAML-513")
@pytest.mark.manual("PAML-517")
@pytest.mark.manual("PAMS-037")
@pytest.mark.parametrize(
    ("age_us", "set_point_delay", "report_delay", "back"),
    [(0, 1, 1, 1), (4000, 1, 1, 5), (0, 0, 0, -1), (500, 2, 3, 4.5)],
)
def test_an_event_is_computed_back_to_its_instant(
    age_us: int, set_point_delay: float, report_delay: float, back: float
) -> None:
    bench = running("COR_Mark", set_point_delay_periods=set_point_delay, report_delay_cycles=report_delay)
    bench.cycle(50)
    last = bench.ask("COR_Mark", "value")
    bench.do("COR_Mark", "trigger", 180)
    mark(bench, age_us)
    assert bench.ask("COR_Mark", "latched_value") == pytest.approx(last - back)
    assert bench.ask("COR_Mark", "latched_d_value") == pytest.approx(1000)
    assert bench.ask("COR_Mark", "latched_dd_value") == pytest.approx(0, abs=1e-3)


@pytest.mark.manual("PAML-513")
@pytest.mark.manual("PAML-517")
@pytest.mark.parametrize(("age_us", "back"), [(0, 1), (3000, 4), (9000, 10)])
def test_an_event_during_an_acceleration_is_computed_back_with_it(age_us: int, back: int) -> None:
    """The flow was there at its instant, with the speed of that instant: is = x - v D + a D2 / 2 (5292-5302)."""
    bench = running("COR_Mark", speed=0, set_point_delay_periods=1, report_delay_cycles=1)
    bench.item("TMP_Belt").set_parameter("ACCELERATION", 5000)
    bench.do("TMP_Belt", "run", 1000)
    flow: list[float] = []
    for _ in range(60):
        bench.cycle()
        flow.append(bench.ask("COR_Mark", "value"))
    bench.do("COR_Mark", "trigger", 180)
    mark(bench, age_us)
    assert bench.ask("COR_Mark", "latched_value") == pytest.approx(flow[-1 - back])
    assert bench.ask("COR_Mark", "latched_d_value") == pytest.approx((60 - back) * 5)
    assert bench.ask("COR_Mark", "latched_dd_value") == pytest.approx(5000)


@pytest.mark.manual("PAML-466")
def test_a_comparator_misses_no_value_of_the_flow() -> None:
    """It evaluates every value, so one that is there for a single period starts both routines (5007)."""
    bench = running("CMP_Full", speed=0)
    bench.item("CMP_Full").set_parameter("REVERSE_ROUTINE", RoutineRef("RTN_Down"))
    flow: list[tuple[float, list[str]]] = [
        (200, ["RTN_Up"]),
        (210, []),
        (0, ["RTN_Down"]),
        (1, []),
        (180, ["RTN_Up"]),
        (179.999, ["RTN_Down"]),
    ]
    for position, routines in flow:
        bench.do("TMP_Belt", "position", position)
        bench.kernel.routines.clear()
        bench.cycle()
        assert [started.routine for started in bench.kernel.routines] == routines


@pytest.mark.manual("PAML-505")
@pytest.mark.manual("PAML-509")
@pytest.mark.manual("PAML-510")
@pytest.mark.manual("PAML-511")
@pytest.mark.manual("PAMS-028")
def test_a_correction_on_request() -> None:
    bench = running("COR_Mark", speed=0)
    bench.cycle(50)
    assert [bench.ask("COR_Mark", name) for name in ("ready", "triggered")] == [True, False]
    mark(bench)
    assert not bench.ask("COR_Mark", "triggered")  # it waits for no event
    bench.do("COR_Mark", "trigger", 170)
    bench.kernel.touched_names.clear()
    mark(bench)
    assert "COR_Mark" in bench.kernel.touched_names
    assert [bench.ask("COR_Mark", name) for name in ("ready", "triggered")] == [True, True]
    assert bench.ask("COR_Mark", "correction") == 170
    bench.do("COR_Mark", "start_correction", -180)
    assert (bench.ask("COR_Mark", "correction"), bench.ask("COR_Mark", "ready")) == (-180, False)
    cycles = bench.until(lambda: bool(bench.ask("COR_Mark", "ready")))
    assert cycles == pytest.approx(1000 * 2 * (180 / 3600) ** 0.5, abs=1)  # a triangle with 3600 u/s2
    assert bench.ask("COR_Mark", "value") == -180


@pytest.mark.manual("PAML-501")
@pytest.mark.manual("PAML-512")
def test_a_corrector_that_is_off_takes_no_event() -> None:
    bench = running("COR_Mark")
    bench.do("COR_Mark", "trigger", 180)
    bench.do("COR_Mark", "trigger_off")
    mark(bench)
    assert not bench.ask("COR_Mark", "triggered")


@pytest.mark.manual("PAML-515")
@pytest.mark.manual("PAML-516")
@pytest.mark.manual("PAML-504")
@pytest.mark.manual("PAML-508")
def test_a_repetitive_corrector_follows_the_marks() -> None:
    bench = running("COR_Always", set_point_delay_periods=0, report_delay_cycles=1)
    bench.item("COR_Always").set_parameter("DELAY_COMPENSATION", 0)
    bench.do("COR_Always", "trigger", 200)
    differences = []
    for _ in range(3):
        bench.until(lambda: 299 < bench.ask("TMP_Belt", "position") < 301)
        before = bench.ask("COR_Always", "value") - bench.ask("TMP_Belt", "position")
        mark(bench)
        bench.cycle(150)
        differences.append(bench.ask("COR_Always", "value") - bench.ask("TMP_Belt", "position") - before)
    assert differences == pytest.approx([100, 100, 100], abs=2)  # the reference INPUT does not see its own corrections


@pytest.mark.manual("PAML-500")
@pytest.mark.manual("PAML-514")
def test_the_delay_of_a_sensor_follows_from_two_runs() -> None:
    """delay = (error B - error A) / (speed B - speed A), with a sensor that is 4 ms late."""
    errors = {}
    for speed in (100, 1000):
        bench = running("COR_Mark", speed=speed, set_point_delay_periods=0, report_delay_cycles=1)
        bench.until(lambda here=bench: here.ask("COR_Mark", "value") >= 100)  # type: ignore[misc]
        passed = bench.ask("COR_Mark", "value")
        bench.do("COR_Mark", "trigger", passed)
        bench.cycle(4)
        mark(bench)
        errors[speed] = -bench.ask("COR_Mark", "correction")
    delay_s = (errors[1000] - errors[100]) / (1000 - 100)
    assert delay_s == pytest.approx(0.004)
    bench.item("COR_Mark").set_parameter("DELAY_COMPENSATION", delay_s)
    passed = bench.ask("COR_Mark", "value")
    bench.do("COR_Mark", "trigger_off")
    bench.do("COR_Mark", "trigger", passed)
    bench.cycle(4)
    mark(bench)
    assert bench.ask("COR_Mark", "correction") == pytest.approx(0, abs=1e-6)


@settings(max_examples=20, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["trigger", "trigger_off", "start_correction", "mark"]),
            st.floats(-100, 100),
            st.integers(1, 60),
        ),
        min_size=1,
        max_size=12,
    )
)
def test_corrections_never_step(commands: list[tuple[str, float, int]]) -> None:
    bench = running("COR_Always", "COR_Mark", speed=0)
    values = [0.0]
    for command, argument, cycles in commands:
        if command == "mark":
            mark(bench)
            values.append(bench.ask("COR_Always", "value"))
        else:
            arguments = () if command == "trigger_off" else (argument,)
            for name in ("COR_Always", "COR_Mark"):
                bench.do(name, command, *arguments)
        for _ in range(cycles):
            bench.cycle()
            values.append(bench.ask("COR_Always", "value"))
    steps = [after - before for before, after in pairwise(values)]
    assert max(map(abs, steps)) <= 2 * 3600 * 0.001 * 1.001
