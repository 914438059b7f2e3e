"""Objects where the manual can be read in two ways: an option of the PAM selects the reading."""

from collections.abc import Callable
from typing import Any

import pytest
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pam.pipes.shapes import shape_of
from fieldrig_devices.pamring.frames import AxisOrder, AxisReport, Move, SetOutput

TURN = 1 << 32
MACHINE = """
NODE NOD_Main; ADDRESS = 1; TYPE = ST1; END
NODE NOD_Desk; ADDRESS = 17; TYPE = SMART_IO; END
AXIS AXI_Main; NODE = NOD_Main; PULSES_PER_UNIT = 11930464.71111111; TRAVEL_SPEED = 720; ACCELERATION = 36000;
  INITIAL_POSITION = 30; POSITION_PERIOD = 360; END
ZERO_POSITIONER ZEP_Main; OBJECT = AXI_Main; RESOLVER_OFFSET = 100; END
BINARY_INPUT SBI_Mark; NODE = NOD_Desk; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
DIGITAL_INPUT SDI_Code; NODE = NOD_Desk; BITS = 5; ADDRESS = 208; ACTIVE = LOW; PERIOD = 1; DEBOUNCE = 1; END
DIGITAL_OUTPUT SDO_Code; NODE = NOD_Desk; BITS = 6; ADDRESS = 201; ACTIVE = LOW; END
PAM_ANALOG_OUTPUT PAO_Probe; UNITS_PER_VOLT = 1; OFFSET = 0; ADDRESS = 0; END
ROUTINES RGR_All;
  ROUTINE RTN_Up; END_ROUTINE
END_ROUTINES
SINK SNK_Values; END
CONVERTER CNV_Values; DESTINATION = SNK_Values; MODE = VALUE; END
TMP_GENERATOR TMP_Belt; TRAVEL_SPEED = 1000; ACCELERATION = 1000000; INITIAL_POSITION = 90; POSITION_PERIOD = 500;
  PERIOD = 0.001; ANTI_DELAY = NO; END
PMP_GENERATOR PMP_Cut; FIRST_TRAVEL_SPEED = 9000; LAST_TRAVEL_SPEED = 4500; ACCELERATION = 45000; JERK = 450000;
  INITIAL_POSITION = 0; POSITION_RANGE = 0 1; PERIOD = 0.001; ANTI_DELAY = NO; END
AMPLIFIER AMP_Gear; GAIN = 2; OFFSET = 0; GAIN_SLOPE = MAX; OFFSET_SLOPE = 100; END
COMPARATOR CMP_Low; REFERENCE = 10; ROUTINE = RTN_Up; END
PROFILE PRO_Feed; FILE = FEED; INPUT_AMPLITUDE = 360; OUTPUT_AMPLITUDE = 100; INPUT_OFFSET = 0; OUTPUT_OFFSET = 0; END
PROFILE PRO_Other; FILE = FEED; INPUT_AMPLITUDE = 1; OUTPUT_AMPLITUDE = 7; INPUT_OFFSET = 0; OUTPUT_OFFSET = 0; END
CAM CAM_Feed; PROFILE = PRO_Feed; VALUE_RANGE = 0 200; END
MULTI_COMPARATOR MUL_Doors; TIME_ORIGIN_SLOPE = POSITIVE; TIME_ORIGIN_COMPARE_MODE = IMMEDIATE;
  TIME_ORIGIN_REFERENCE = 100; VALUE_PERIOD = 500;
  TRACE TRC_One; ROUTINE = RTN_Up; END
END
CORRECTOR COR_Mark; CORRECTION_SLOPE = 1; CORRECTION_LEVEL = 1; CORRECTION_REFERENCE = OUTPUT;
  CORRECTION_MODE = IMMEDIATE; TRIGGER_MODE = ONCE; TRIGGER_INPUT = SBI_Mark; DELAY_COMPENSATION = 0; END
"""


def machine(*blocks: str, volts: Callable[[int, float], None] = lambda _address, _volts: None, **options: Any) -> Bench:
    """The machine, with a pipe through these blocks if there are any."""
    bench = Bench(
        HEADER + MACHINE, readings=ObjectReadings(**options), shapes=lambda _: shape_of(b"0 0\n1 1\n"), volts=volts
    )
    bench.st1(1)
    if blocks:
        bench.connect("CNV_Values", *blocks, "TMP_Belt")
    bench.cycle(2)
    return bench


def orders(bench: Bench) -> list[AxisOrder]:
    return [order for order in bench.sent(1) if isinstance(order, AxisOrder)]


@pytest.mark.parametrize("is_ready", [False, True])
def test_an_axis_that_runs_is_ready_at_its_speed_or_at_the_end(is_ready: bool) -> None:
    bench = machine(run_is_ready_at_speed=is_ready)
    bench.do("AXI_Main", "run", 720)
    assert not bench.ask("AXI_Main", "ready")
    bench.cycle(100)
    assert bench.ask("AXI_Main", "ready") is is_ready
    bench.do("AXI_Main", "run", 0)
    assert not bench.ask("AXI_Main", "ready")
    bench.cycle(100)
    assert bench.ask("AXI_Main", "ready")


def test_a_run_that_the_node_has_ended_is_over() -> None:
    bench = machine(run_is_ready_at_speed=False)
    bench.do("AXI_Main", "run", 720)
    number = orders(bench)[-1].number
    bench.objects.on_report(1, AxisReport(4, 0, number, 0))
    assert not bench.ask("AXI_Main", "ready")
    bench.objects.on_report(1, AxisReport(16 | 32, 0x8000_0000, number, 0))
    assert bench.ask("AXI_Main", "ready")


@pytest.mark.parametrize(("sets_initial", "position"), [(False, 0), (True, 30)])
def test_power_on_sets_zero_or_the_initial_position(sets_initial: bool, position: float) -> None:
    bench = machine(power_on_sets_initial_position=sets_initial)
    bench.do("AXI_Main", "position", 77)
    bench.do("AXI_Main", "power_on")
    assert bench.ask("AXI_Main", "position") == position
    order = orders(bench)[-1]
    assert (order.move, order.value) == (Move.POWER_ON, round(position * 11930464.71111111))


@pytest.mark.parametrize("is_shown", [False, True])
def test_an_st1_node_has_the_errors_of_its_axis_or_none(is_shown: bool) -> None:
    bench = machine(st1_nodes_have_errors=is_shown)
    bench.kernel.touched_names.clear()
    bench.objects.on_report(1, AxisReport(0, 0x1000_0010, 0, 0))
    assert bench.ask("NOD_Main", "error") is is_shown
    assert bench.ask("NOD_Main", "error_code") == (0x1000_0010 if is_shown else 0)
    assert ("NOD_Main" in bench.kernel.touched_names) is is_shown


@pytest.mark.parametrize(("reverses", "number", "bits"), [(False, 0b00011, 0b111110), (True, 0b11000, 0b011111)])
def test_the_lowest_address_is_the_lowest_or_the_highest_bit(reverses: bool, number: int, bits: int) -> None:
    bench = machine(lowest_address_is_highest_bit=reverses)
    bench.change(17, 2, 0b11100)  # low, and so active, at 208 and 209
    assert bench.item("SDI_Code").value() == number
    bench.item("SDO_Code").set_value(1)
    assert bench.sent(17)[-1] == SetOutput(3, bits)  # low at 201 or at 206


@pytest.mark.parametrize("acts_at_once", [False, True])
def test_a_written_parameter_of_a_profile_acts_at_once_or_with_the_cam(acts_at_once: bool) -> None:
    bench = machine("CAM_Feed", profiles_act_at_once=acts_at_once)
    assert bench.ask("CAM_Feed", "value") == pytest.approx(25)  # the belt is at 90
    bench.cycle(20)
    bench.item("PRO_Other").set_parameter("OUTPUT_AMPLITUDE", 1)
    bench.item("PRO_Feed").set_parameter("OUTPUT_AMPLITUDE", 200)
    bench.cycle()
    assert bench.ask("CAM_Feed", "value") == pytest.approx(50 if acts_at_once else 25)
    bench.item("CAM_Feed").set_parameter("PROFILE", bench.item("PRO_Feed"))
    bench.cycle()
    assert bench.ask("CAM_Feed", "value") == pytest.approx(50)


@pytest.mark.parametrize("takes_both", [False, True])
def test_a_corrector_takes_the_rising_edge_or_both(takes_both: bool) -> None:
    bench = machine("COR_Mark", corrector_takes_both_edges=takes_both)
    bench.change(17, 1, 1)
    bench.cycle()
    bench.do("COR_Mark", "trigger", 80)
    bench.change(17, 1, 0)
    bench.cycle()
    assert bench.ask("COR_Mark", "triggered") is takes_both


@pytest.mark.parametrize("is_ended", [False, True])
def test_trigger_off_during_a_correction(is_ended: bool) -> None:
    bench = machine("COR_Mark", trigger_off_ends_correction=is_ended)
    bench.do("COR_Mark", "trigger", 100)
    bench.change(17, 1, 1)
    bench.cycle(500)
    bench.do("COR_Mark", "trigger_off")
    bench.until(lambda: bool(bench.ask("COR_Mark", "ready")))
    assert bench.ask("COR_Mark", "value") == pytest.approx(90.25 if is_ended else 100, abs=0.01)  # 0.5 s with 1 u/s2


@pytest.mark.parametrize(("supersedes", "place"), [(False, 4500), (True, 100)])
def test_a_command_to_a_moving_pmp(supersedes: bool, place: float) -> None:
    bench = machine(pmp_supersedes=supersedes)
    bench.connect("CNV_Values", "PMP_Cut")
    bench.cycle()
    bench.do("PMP_Cut", "relative_move", 4500)
    bench.cycle(150)
    bench.do("PMP_Cut", "absolute_move", 100)
    bench.until(lambda: bool(bench.ask("PMP_Cut", "ready")))
    assert bench.ask("PMP_Cut", "position") == pytest.approx(place)


# ---- passages without a setting: what the PAM does


def test_the_resolver_phase_goes_the_shorter_way() -> None:
    bench = machine()
    bench.nodes[1].registers[0] = 65536 * 150 // 360
    bench.do("ZEP_Main", "start")
    bench.until(lambda: bool(bench.ask("ZEP_Main", "ready")))
    assert orders(bench)[0].move is Move.RELATIVE_MOVE
    assert orders(bench)[0].value == pytest.approx(-50 / 360 * TURN, rel=1e-3)


@pytest.mark.parametrize(("wanted", "step"), [(1.245, 127), (1.2401, 126), (2.5, 255)])
def test_the_analog_outputs_take_the_nearest_of_255_steps(wanted: float, step: int) -> None:
    seen: dict[int, float] = {}
    machine(volts=seen.__setitem__).item("PAO_Probe").set_value(wanted)
    assert seen[0] == pytest.approx(step * 2.5 / 255)


def test_a_comparator_that_begins_above_its_reference_starts_nothing() -> None:
    assert machine("CMP_Low").kernel.routines == []


def test_a_comparator_through_zero_counts_both_directions_and_then_compares() -> None:
    bench = machine("CMP_Low")
    bench.item("CMP_Low").set_parameter("THROUGH_ZERO_REFERENCE", 100)

    def starts(*places: float) -> int:
        bench.kernel.routines.clear()
        for place in places:
            bench.do("TMP_Belt", "position", place)
            bench.cycle()
        return len(bench.kernel.routines)

    assert [starts(10, 490), starts(10, 90, 110, 90, 110)] == [1, 2]


def test_an_offset_changes_with_its_own_slope() -> None:
    bench = machine("AMP_Gear")
    bench.item("AMP_Gear").set_parameter("OFFSET", 1)
    assert bench.until(lambda: bool(bench.ask("AMP_Gear", "ready"))) == 10


def test_a_reference_that_is_installed_out_of_turn_is_learned_again() -> None:
    """A known one would fire by its time, 10 ms earlier."""
    bench = machine("MUL_Doors")

    def fires_at(reference: float) -> float:
        bench.kernel.routines.clear()
        bench.do("TRC_One", "install_reference", "POSITIVE", "IMMEDIATE", reference, 0.010)
        bench.until(lambda: bool(bench.kernel.routines))
        return float(bench.ask("MUL_Doors", "value"))

    bench.do("TMP_Belt", "run", 1000)
    bench.do("MUL_Doors", "learn")
    assert [fires_at(200), fires_at(300)] == pytest.approx([200, 300], abs=1)
    bench.do("MUL_Doors", "execute")
    assert fires_at(300) == pytest.approx(300, abs=1)
