"""Pipes: how they begin, end and share blocks, and golden numbers of the digest through the items of programs."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pam.pipes.shapes import shape_of

RANGE = "POSITION_RANGE = -1 1;"
PIPES = """
SINK SNK_Values; END
SINK SNK_Others; END
TMP_GENERATOR TMP_Master; TRAVEL_SPEED = 6; ACCELERATION = 0.3; DECELERATION = 0.6; INITIAL_POSITION = 0;
  POSITION_PERIOD = 678; PERIOD = 0.001; ANTI_DELAY = NO; END
TMP_GENERATOR TMP_Slow; TRAVEL_SPEED = 6; ACCELERATION = 1000; INITIAL_POSITION = 0; POSITION_RANGE = 0 1;
  PERIOD = 0.0104; ANTI_DELAY = NO; END
PMP_GENERATOR PMP_Cut; FIRST_TRAVEL_SPEED = 9000; LAST_TRAVEL_SPEED = 4500; ACCELERATION = 45000; JERK = 450000;
  INITIAL_POSITION = 0; POSITION_RANGE = 0 1; PERIOD = 0.001; ANTI_DELAY = NO; END
AMPLIFIER AMP_Gear; GAIN = 2; OFFSET = 5; GAIN_SLOPE = 1; OFFSET_SLOPE = MAX; END
AMPLIFIER AMP_Half; GAIN = 0.5; OFFSET = 0; GAIN_SLOPE = MAX; OFFSET_SLOPE = MAX; END
DERIVATOR DER_Speed; VALUE_PERIOD = 678; END
PHASER PHA_Shift; PHASE = 10; PHASE_SLOPE = 100; STANDBY_VALUE = 0; VALUE_PERIOD = 90; END
PROFILE PRO_Feed; FILE = FEED; INPUT_AMPLITUDE = 360; OUTPUT_AMPLITUDE = 100; INPUT_OFFSET = 0; OUTPUT_OFFSET = 10; END
PROFILE PRO_Other; FILE = FEED; INPUT_AMPLITUDE = 1; OUTPUT_AMPLITUDE = 7; INPUT_OFFSET = 0; OUTPUT_OFFSET = 0; END
CAM CAM_Feed; PROFILE = PRO_Feed; VALUE_RANGE = 0 200; END
DISTRIBUTOR DIS_First; DIVISOR = 5; SHIFT = 0; END
DISTRIBUTOR DIS_Second; DIVISOR = 5; SHIFT = 1; END
CONVERTER CNV_Values; DESTINATION = SNK_Values; MODE = VALUE; END
CONVERTER CNV_Again; DESTINATION = SNK_Values; MODE = POSITION; END
CONVERTER CNV_Others; DESTINATION = SNK_Others; MODE = TORQUE; END
PAM_ANALOG_OUTPUT PAO_Probe; UNITS_PER_VOLT = 100; OFFSET = 0; ADDRESS = 0; END
CONVERTER CNV_Probe; DESTINATION = PAO_Probe; MODE = VALUE; END
"""
STRAIGHT = b"0 0\n1 1\n"


def machine(thirds: int = 3, **options: object) -> Bench:
    header = HEADER.replace("BASIC_PAM_CYCLE = 3", f"BASIC_PAM_CYCLE = {thirds}")
    return Bench(header + PIPES, shapes=lambda _name: shape_of(STRAIGHT), readings=ObjectReadings(**options))  # type: ignore[arg-type]


@pytest.fixture
def bench() -> Bench:
    return machine()


def is_ready(bench: Bench, name: str) -> bool:
    return bool(bench.ask(name, "ready"))


@pytest.mark.manual("PAMS-040")
@pytest.mark.manual("PAML-400")
@pytest.mark.manual("PAML-403")
@pytest.mark.manual("PAML-404")
def test_a_pipe_is_active_when_its_converter_is_ready(bench: Bench) -> None:
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Master")
    assert not is_ready(bench, "CNV_Values")
    bench.cycle()
    assert is_ready(bench, "CNV_Values")
    assert bench.ask("AMP_Gear", "value") == 10
    bench.do("CNV_Values", "deactivate")
    assert not is_ready(bench, "CNV_Values")


@pytest.mark.manual("PAML-402")
@pytest.mark.manual("PAML-413")
@pytest.mark.parametrize(("thirds", "name", "period"), [(3, "TMP_Slow", 0.010), (6, "TMP_Master", 0.002)])
def test_the_effective_period_is_read_and_used(thirds: int, name: str, period: float) -> None:
    bench = machine(thirds)
    assert bench.item(name).parameter("PERIOD") == pytest.approx(period)
    bench.connect("CNV_Values", name)
    bench.cycle(2)
    bench.do(name, "run", 6)
    values = set()
    for _ in range(40):
        bench.cycle()
        values.add(bench.ask(name, "position"))
    assert len(values) == pytest.approx(40 * bench.cycle_s / period, abs=1)


@pytest.mark.manual("PAML-634")
@pytest.mark.manual("PAML-407")
@pytest.mark.manual("PAML-409")
def test_a_block_lives_from_its_first_pipe_to_its_last(bench: Bench) -> None:
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Master")
    bench.connect("CNV_Others", "AMP_Gear", "TMP_Master")
    bench.cycle(2)
    bench.do("TMP_Master", "position", 100)
    bench.do("CNV_Values", "disactivate")
    bench.cycle()
    assert bench.ask("TMP_Master", "position") == 100  # it lives on in the other pipe
    bench.do("CNV_Others", "disactivate")
    bench.cycle()
    assert bench.ask("TMP_Master", "position") == 0  # PAML-634
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Master")
    bench.cycle()
    assert bench.ask("AMP_Gear", "value") == 10  # and began again


@pytest.mark.manual("PAML-432")
@pytest.mark.manual("PAML-409")
def test_the_parameters_of_the_declaration_come_back_with_a_new_life(bench: Bench) -> None:
    bench.item("AMP_Gear").set_parameter("GAIN", 3)
    assert bench.item("AMP_Gear").parameter("GAIN") == 3  # at once, as it is not active
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Master")
    bench.cycle()
    assert bench.item("AMP_Gear").parameter("GAIN") == 2


@pytest.mark.manual("PAML-407")
def test_a_new_pipe_replaces_the_one_with_its_destination(bench: Bench) -> None:
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Master")
    bench.cycle()
    bench.connect("CNV_Again", "AMP_Gear", "TMP_Slow")  # shared, with another input: the destination is the same
    bench.cycle(11)
    assert [is_ready(bench, name) for name in ("CNV_Values", "CNV_Again")] == [False, True]
    assert "CNV_Values" in bench.kernel.touched_names
    bench.do("TMP_Slow", "position", 1)
    bench.cycle(11)
    assert bench.ask("AMP_Gear", "value") == 12


@pytest.mark.manual("PAML-408")
def test_a_shared_block_computes_once_in_a_period(bench: Bench) -> None:
    bench.connect("CNV_Values", "DER_Speed", "TMP_Master")
    bench.connect("CNV_Others", "AMP_Half", "DER_Speed", "TMP_Master")
    bench.cycle(2)
    bench.do("TMP_Master", "run", 0.3)
    bench.cycle(1500)
    assert bench.ask("DER_Speed", "value") == pytest.approx(0.3)
    assert bench.ask("AMP_Half", "value") == pytest.approx(0.15)


@pytest.mark.manual("PAML-608")
@pytest.mark.manual("PAML-412")
@pytest.mark.parametrize(
    ("is_distributed", "blocks_per_ms", "is_overrun"),
    [(False, 7, False), (False, 6, True), (True, 6, False), (True, 5, True)],
)
def test_pipes_that_take_too_long_are_a_fatal_error(is_distributed: bool, blocks_per_ms: int, is_overrun: bool) -> None:
    bench = machine(blocks_per_ms=blocks_per_ms)
    bench.connect("CNV_Values", "AMP_Gear", *(["DIS_First"] * is_distributed), "TMP_Master")
    bench.connect("CNV_Others", "AMP_Half", *(["DIS_Second"] * is_distributed), "TMP_Master")
    bench.connect("CNV_Probe", "DER_Speed", "TMP_Master")
    bench.cycle(10)
    assert bench.kernel.reports[:1] == [("02..F060", ())] * is_overrun


@pytest.mark.manual("PAML-540")
@pytest.mark.manual("PAML-542")
@pytest.mark.manual("PAML-414")
def test_distributors_spread_the_work(bench: Bench) -> None:
    bench.connect("CNV_Values", "AMP_Gear", "DIS_First", "TMP_Master")
    bench.connect("CNV_Others", "AMP_Half", "DIS_Second", "TMP_Master")
    bench.connect("CNV_Probe", "DER_Speed", "TMP_Master")
    bench.do("TMP_Master", "run", 0.3)
    names = ("AMP_Gear", "AMP_Half", "DER_Speed")
    values: list[list[float]] = []
    for _ in range(12):
        bench.cycle()
        values.append([bench.ask(name, "value") for name in names])
    computed = [[name for name, old, new in zip(names, *pair, strict=True) if old != new] for pair in pairwise(values)]
    each = [["DER_Speed"], ["DER_Speed"], ["DER_Speed"], ["AMP_Gear", "DER_Speed"], ["AMP_Half", "DER_Speed"]]
    assert computed[1:] == [*each, *each]


@pytest.mark.manual("PAML-107")
def test_a_pipe_is_probed_by_an_analog_output() -> None:
    volts: dict[int, float] = {}
    bench = Bench(HEADER + PIPES, volts=volts.__setitem__, shapes=lambda _name: shape_of(STRAIGHT))
    bench.connect("CNV_Probe", "TMP_Master")
    bench.cycle()
    bench.do("TMP_Master", "position", 150)
    bench.cycle()
    assert volts[0] == pytest.approx(1.5, abs=0.01)
    assert bench.item("PAO_Probe").value() == 150
    assert "PAO_Probe" in bench.kernel.touched_names


@pytest.mark.manual("PAML-635")
@pytest.mark.parametrize(("word", "lead"), [("NO", 0), ("YES", 1)])
def test_anti_delay_is_one_period_ahead_of_the_position(word: str, lead: int) -> None:
    bench = Bench(
        HEADER + PIPES.replace("ANTI_DELAY = NO", f"ANTI_DELAY = {word}"), shapes=lambda _: shape_of(STRAIGHT)
    )
    bench.connect("CNV_Values", "AMP_Half", "TMP_Slow")
    bench.cycle(11)
    bench.do("TMP_Slow", "run", 6)
    bench.cycle(100)
    flow, position = 2 * bench.ask("AMP_Half", "value"), bench.ask("TMP_Slow", "position")
    assert flow - position == pytest.approx(6 * 0.010 * lead)


@pytest.mark.manual("PAML-180")
@pytest.mark.manual("PAML-181")
@pytest.mark.parametrize("mode", ["POSITION", "SPEED", "TORQUE", "VALUE"])
def test_a_sink_takes_values_of_every_mode(mode: str) -> None:
    bench = Bench(
        f"{HEADER}{PIPES}CONVERTER CNV_Sink; DESTINATION = SNK_Others; MODE = {mode}; END\n",
        shapes=lambda _name: shape_of(STRAIGHT),
    )
    bench.connect("CNV_Sink", "TMP_Master")
    bench.cycle(10)
    assert is_ready(bench, "CNV_Sink")
    assert bench.port.sent == []


@pytest.mark.manual("PAML-411")
def test_pipes_that_share_a_block_compute_in_the_same_cycles(bench: Bench) -> None:
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Slow")
    bench.cycle(4)
    bench.connect("CNV_Others", "AMP_Half", "TMP_Slow")
    bench.do("TMP_Slow", "run", 6)
    values = []
    for _ in range(30):
        bench.cycle()
        values.append((bench.ask("AMP_Gear", "value"), bench.ask("AMP_Half", "value")))
    steps = [cycle for cycle, (old, new) in enumerate(pairwise(values)) if old != new]
    assert len(steps) == 3
    assert all(old[0] != new[0] and old[1] != new[1] for old, new in pairwise(values) if old != new)


@pytest.mark.manual("PAML-445")
@pytest.mark.manual("PAML-449")
def test_the_output_of_a_cam_is_within_its_period() -> None:
    bench = Bench(
        HEADER + PIPES.replace("VALUE_RANGE = 0 200", "VALUE_PERIOD = 90"), shapes=lambda _: shape_of(STRAIGHT)
    )
    bench.connect("CNV_Values", "CAM_Feed", "TMP_Slow")
    bench.do("TMP_Slow", "position", 360)
    bench.cycle()
    assert bench.ask("CAM_Feed", "value") == pytest.approx(110 - 90)
    assert is_ready(bench, "CAM_Feed")
    bench.item("CAM_Feed").set_parameter("VALUE_PERIOD", 50)
    bench.cycle(11)
    assert bench.ask("CAM_Feed", "value") == pytest.approx(10)


@pytest.mark.manual("PAML-533")
@pytest.mark.manual("PAML-530")
@pytest.mark.manual("PAML-532")
def test_a_derivator_in_programs(bench: Bench) -> None:
    bench.connect("CNV_Values", "DER_Speed", "TMP_Slow")
    bench.do("TMP_Slow", "position", 5)
    bench.cycle()
    assert (bench.ask("DER_Speed", "value"), is_ready(bench, "DER_Speed")) == (0, True)
    bench.do("TMP_Slow", "position", 6)
    bench.cycle(10)
    assert bench.ask("DER_Speed", "value") == pytest.approx(1 / 0.010)


@pytest.mark.manual("PAML-433")
def test_the_rest_of_a_slew_is_applied_at_the_end_of_the_pipe(bench: Bench) -> None:
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Master")
    bench.cycle()
    bench.item("AMP_Gear").set_parameter("GAIN", 4)
    bench.cycle(10)
    bench.kernel.touched_names.clear()
    bench.do("CNV_Values", "disactivate")
    assert bench.item("AMP_Gear").parameter("GAIN") == 4
    assert is_ready(bench, "AMP_Gear")
    assert {"AMP_Gear", "CNV_Values"} <= bench.kernel.touched_names


@pytest.mark.manual("PAML-581")
@pytest.mark.manual("PAML-586")
def test_a_phaser_is_started_unless_it_was_stopped_before(bench: Bench) -> None:
    phaser = bench.item("PHA_Shift")
    bench.connect("CNV_Values", "PHA_Shift", "TMP_Slow")
    bench.cycle()
    phaser.set_parameter("PHASE", 20)
    bench.until(lambda: is_ready(bench, "PHA_Shift"))
    bench.cycle(10)
    assert (phaser.parameter("PHASE"), bench.ask("PHA_Shift", "value")) == (20, 20)
    bench.do("CNV_Values", "disactivate")
    bench.do("PHA_Shift", "stop")
    bench.connect("CNV_Values", "PHA_Shift", "TMP_Slow")
    bench.cycle()
    assert (bench.ask("PHA_Shift", "value"), is_ready(bench, "PHA_Shift")) == (0, True)


@pytest.mark.manual("PAMS-026")
def test_a_run_of_the_pmp_is_replaced_by_a_move(bench: Bench) -> None:
    bench.connect("CNV_Values", "PMP_Cut")
    bench.cycle()
    bench.do("PMP_Cut", "run", 4500)
    assert bench.until(lambda: is_ready(bench, "PMP_Cut")) == pytest.approx(200, abs=1)  # 4500 u/s with the jerk
    bench.cycle(100)
    assert bench.ask("PMP_Cut", "speed") == pytest.approx(4500)
    before = bench.ask("PMP_Cut", "position")
    bench.do("PMP_Cut", "relative_move", 1000)
    bench.until(lambda: is_ready(bench, "PMP_Cut"))
    bench.cycle(100)
    assert bench.ask("PMP_Cut", "position") == pytest.approx(before + 1000)
    bench.do("PMP_Cut", "run", -900)
    bench.until(lambda: is_ready(bench, "PMP_Cut"))
    bench.do("PMP_Cut", "run", 0)
    bench.until(lambda: is_ready(bench, "PMP_Cut"))
    at = bench.ask("PMP_Cut", "position")
    bench.cycle(50)
    assert bench.ask("PMP_Cut", "position") == pytest.approx(at)


# ---- golden numbers (section 7 of the digest), within one period


@pytest.mark.long
@pytest.mark.manual("PAML-630")
@pytest.mark.manual("PAMS-026")
@pytest.mark.manual("PAMS-036")
def test_tmp_450_units() -> None:
    bench = machine(30)  # periods of 10 ms
    bench.connect("CNV_Values", "TMP_Master")
    bench.cycle()
    bench.do("TMP_Master", "relative_move", 450)
    assert not is_ready(bench, "TMP_Master")
    bench.cycle(2000)
    assert bench.ask("TMP_Master", "position") == pytest.approx(60, abs=0.06)
    assert bench.ask("TMP_Master", "speed") == pytest.approx(6)
    assert bench.ask("TMP_Master", "acceleration") == 0
    bench.cycle(6000)
    assert bench.ask("TMP_Master", "position") == pytest.approx(420, abs=0.06)
    assert bench.until(lambda: is_ready(bench, "TMP_Master")) == pytest.approx(1000, abs=1)
    assert bench.ask("TMP_Master", "position") == pytest.approx(450)
    bench.do("TMP_Master", "relative_move", 450)
    bench.until(lambda: is_ready(bench, "TMP_Master"))
    assert bench.ask("TMP_Master", "position") == pytest.approx(900 - 678)


@pytest.mark.manual("PAML-600")
def test_pmp_4500_units(bench: Bench) -> None:
    bench.connect("CNV_Values", "PMP_Cut")
    bench.cycle()
    bench.do("PMP_Cut", "absolute_move", 4500)
    seen = {}
    for cycle in range(1, 801):
        bench.cycle()
        seen[cycle] = bench.ask("PMP_Cut", "position")
    golden = {100: 75, 200: 525, 300: 1350, 500: 3150, 600: 3975, 700: 4425, 800: 4500}
    for cycle, position in golden.items():
        assert seen[cycle] == pytest.approx(position, abs=9)  # 9000 u/s for 1 ms
    bench.cycle()
    assert is_ready(bench, "PMP_Cut")


@pytest.mark.manual("PAML-602")
@pytest.mark.manual("PAML-601")
@pytest.mark.manual("PAMS-019")
def test_pmp_forward_and_backward(bench: Bench) -> None:
    bench.connect("CNV_Values", "PMP_Cut")
    bench.cycle()
    bench.do("PMP_Cut", "relative_move", 4500, -2000)
    assert bench.until(lambda: is_ready(bench, "PMP_Cut")) == pytest.approx(1351, abs=1)
    assert bench.ask("PMP_Cut", "position") == pytest.approx(2500)
    bench.do("PMP_Cut", "absolute_move", 1000, 500)  # the same direction is not done
    assert is_ready(bench, "PMP_Cut")
    bench.do("PMP_Cut", "absolute_move", 2500, 1000)  # it is at the first already
    bench.until(lambda: is_ready(bench, "PMP_Cut"))
    assert bench.ask("PMP_Cut", "position") == pytest.approx(1000)


@pytest.mark.manual("PAML-605")
@pytest.mark.manual("PAML-632")
def test_limits_at_zero_are_ignored_and_new_ones_hold_for_the_next_motion(bench: Bench) -> None:
    for name in ("TMP_Master", "PMP_Cut"):
        bench.item(name).set_parameter("ACCELERATION", 0)
        assert bench.item(name).parameter("ACCELERATION") > 0
    bench.item("PMP_Cut").set_parameter("JERK", -1)
    assert bench.item("PMP_Cut").parameter("JERK") == 450000
    bench.connect("CNV_Values", "TMP_Master")
    bench.cycle()
    bench.do("TMP_Master", "run", 6)
    bench.item("TMP_Master").set_parameter("ACCELERATION", 3)
    bench.cycle(1000)
    assert bench.ask("TMP_Master", "speed") == pytest.approx(0.3)
    bench.do("TMP_Master", "run", 6)
    bench.cycle(1000)
    assert bench.ask("TMP_Master", "speed") == pytest.approx(3.3)


@pytest.mark.manual("PAML-606")
@pytest.mark.manual("PAML-607")
@pytest.mark.manual("PAMS-025")
def test_an_initial_position_waits_for_the_next_activation(bench: Bench) -> None:
    bench.connect("CNV_Values", "TMP_Master")
    bench.cycle()
    bench.item("TMP_Master").set_parameter("INITIAL_POSITION", 55)
    bench.cycle()
    assert bench.ask("TMP_Master", "position") == 0
    bench.do("CNV_Values", "disactivate")
    bench.connect("CNV_Values", "TMP_Master")
    bench.cycle()
    assert bench.ask("TMP_Master", "position") == 55


@pytest.mark.manual("PAML-431")
@pytest.mark.manual("PAML-434")
@pytest.mark.manual("PAML-435")
def test_a_gain_slews_for_2_s(bench: Bench) -> None:
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Master")
    bench.cycle()
    bench.cycle(50)  # the pipe is at rest, and begins to compute again
    bench.item("AMP_Gear").set_parameter("GAIN", 4)
    assert not is_ready(bench, "AMP_Gear")
    bench.cycle(1000)
    assert bench.item("AMP_Gear").parameter("GAIN") == pytest.approx(3)
    assert bench.until(lambda: is_ready(bench, "AMP_Gear")) == pytest.approx(1000, abs=1)
    assert bench.ask("AMP_Gear", "value") == pytest.approx(20)


@pytest.mark.manual("PAML-431")
def test_slopes_are_written_as_numbers_or_max(bench: Bench) -> None:
    amplifier = bench.item("AMP_Gear")
    assert (amplifier.parameter("GAIN_SLOPE"), amplifier.parameter("OFFSET_SLOPE")) == (1, float("inf"))
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Master")
    bench.cycle()
    amplifier.set_parameter("GAIN_SLOPE", "MAX")
    amplifier.set_parameter("OFFSET_SLOPE", 5)
    amplifier.set_parameter("GAIN", 4)
    amplifier.set_parameter("OFFSET", 0)
    bench.cycle(500)
    assert (amplifier.parameter("GAIN"), amplifier.parameter("OFFSET")) == (4, pytest.approx(2.5))


@pytest.mark.manual("PAML-440")
@pytest.mark.manual("PAML-443")
@pytest.mark.manual("PAML-444")
def test_a_profile_works_when_it_is_given_to_the_cam(bench: Bench) -> None:
    bench.connect("CNV_Values", "CAM_Feed", "TMP_Slow")
    values = []
    for position in (-5, 90, 400):
        bench.do("TMP_Slow", "position", position)
        bench.cycle(11)
        values.append(bench.ask("CAM_Feed", "value"))
    assert values == pytest.approx([10, 35, 110])
    bench.item("PRO_Feed").set_parameter("OUTPUT_AMPLITUDE", 50)
    bench.cycle(40)
    assert bench.ask("CAM_Feed", "value") == pytest.approx(110)
    bench.item("CAM_Feed").set_parameter("PROFILE", bench.item("PRO_Feed"))
    bench.cycle(11)
    assert bench.ask("CAM_Feed", "value") == pytest.approx(60)
    bench.item("CAM_Feed").set_parameter("PROFILE", bench.item("PRO_Other"))
    bench.cycle(11)
    assert bench.ask("CAM_Feed", "value") == pytest.approx(7)


@pytest.mark.manual("PAML-446")
@pytest.mark.manual("PAML-410")
def test_a_gear_goes_on_over_the_period_of_its_master() -> None:
    for unwraps, last in ((True, 342.0), (False, 3.0)):
        bench = machine(amplifier_unwraps=unwraps)
        bench.connect("CNV_Values", "AMP_Half", "TMP_Master")
        bench.item("TMP_Master").set_parameter("ACCELERATION", 300)
        bench.do("TMP_Master", "position", 672)
        bench.cycle()
        bench.do("TMP_Master", "relative_move", 12)
        bench.until(lambda here=bench: is_ready(here, "TMP_Master"))  # type: ignore[misc]
        assert bench.ask("TMP_Master", "position") == pytest.approx(6)
        assert bench.ask("AMP_Half", "value") == pytest.approx(last)


@pytest.mark.manual("PAML-587")
@pytest.mark.manual("PAML-589")
@pytest.mark.manual("PAML-410")
def test_a_changed_period_is_that_of_the_blocks_behind_it(bench: Bench) -> None:
    bench.connect("CNV_Values", "AMP_Half", "TMP_Master")
    bench.cycle()
    bench.item("TMP_Master").set_parameter("POSITION_PERIOD", 10)
    bench.do("TMP_Master", "position", 9)
    bench.cycle()
    before = bench.ask("AMP_Half", "value")
    bench.do("TMP_Master", "position", 11)
    bench.cycle()
    assert bench.ask("TMP_Master", "position") == pytest.approx(1)
    assert bench.ask("AMP_Half", "value") == pytest.approx(before + 1)


@pytest.mark.manual("PAML-584")
@pytest.mark.manual("PAMS-027")
def test_a_phaser_in_programs(bench: Bench) -> None:
    bench.connect("CNV_Values", "PHA_Shift", "TMP_Slow")
    bench.cycle()
    assert bench.ask("PHA_Shift", "value") == 10
    bench.item("PHA_Shift").set_parameter("PHASE", 30)
    bench.cycle(100)
    assert bench.item("PHA_Shift").parameter("PHASE") == pytest.approx(20)
    assert not is_ready(bench, "PHA_Shift")
    bench.do("PHA_Shift", "stop")
    assert bench.item("PHA_Shift").parameter("PHASE") == 30
    bench.do("TMP_Slow", "run", 6)
    bench.until(lambda: is_ready(bench, "PHA_Shift"))
    assert (bench.ask("PHA_Shift", "value"), bench.ask("TMP_Slow", "position")) == (0, pytest.approx(60, abs=0.07))


# ---- laws


COMMANDS = st.lists(
    st.tuples(st.sampled_from(["absolute_move", "relative_move", "run"]), st.floats(-20, 20), st.integers(1, 300)),
    min_size=1,
    max_size=6,
)


@pytest.mark.long
@pytest.mark.manual("PAML-631")
@settings(max_examples=25, deadline=None)
@given(COMMANDS)
def test_positions_are_continuous_and_limits_hold_for_any_commands(commands: list[tuple[str, float, int]]) -> None:
    bench = machine()
    bench.connect("CNV_Values", "AMP_Gear", "TMP_Master")
    bench.connect("CNV_Others", "PMP_Cut")
    bench.cycle()
    amplified, positions, speeds = [10.0], [0.0], [0.0]
    for function, argument, cycles in commands:
        limit = 6 if function != "run" else 20
        bench.do("TMP_Master", function, min(max(argument, -limit), limit))
        bench.do("PMP_Cut", function, 100 * argument)
        for _ in range(cycles):
            bench.cycle()
            amplified.append(bench.ask("AMP_Gear", "value"))
            positions.append(bench.ask("PMP_Cut", "position"))
            speeds.append(bench.ask("PMP_Cut", "speed"))
    assert max(abs(after - before) for before, after in pairwise(amplified)) <= 2 * 20 * 0.001
    assert max(abs(after - before) for before, after in pairwise(positions)) <= 9000 * 0.001 * 1.001
    assert max(abs(after - before) for before, after in pairwise(speeds)) <= 45000 * 0.001 * 1.001
    steps = [after - before for before, after in pairwise(amplified)]
    assert max((abs(after - before) for before, after in pairwise(steps)), default=0) <= 2 * 0.6e-6 * 2 * 1.01
