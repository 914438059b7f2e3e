"""Encoders: readings over the ring with and without a sampler, and what hides the roll-over of registers."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.pam.runtime.item import Pending
from fieldrig_devices.pamring.frames import Answer, Read

ENCODERS = (
    HEADER
    + """
NODE NOD_Belt; ADDRESS = 7; TYPE = ST1; END
AXIS AXI_Belt; NODE = NOD_Belt; PULSES_PER_UNIT = 100; TRAVEL_SPEED = 1; ACCELERATION = 1; INITIAL_POSITION = 5;
  POSITION_PERIOD = 360; END
ENCODER ENC_Belt; NODE = NOD_Belt; ADDRESS = 0; PULSES_PER_UNIT = 182.04444444; POSITION_PERIOD = 360; END
ENCODER ENC_Temperature; NODE = NOD_Belt; ADDRESS = 1273; PULSES_PER_UNIT = 16; POSITION_RANGE = 0 60; END
SAMPLER SMP_Belt; SOURCE = ENC_Belt; MODE = POSITION; PERIOD = 0.002; END
SAMPLER SMP_Speed; SOURCE = ENC_Belt; MODE = SPEED; PERIOD = 0.002; END
SAMPLER SMP_Axis; SOURCE = AXI_Belt; MODE = POSITION; PERIOD = 0.001; END
SINK SNK_Values; END
CONVERTER CNV_Values; DESTINATION = SNK_Values; MODE = VALUE; END
"""
)


@pytest.fixture
def bench() -> Bench:
    return Bench(ENCODERS)


def answer(bench: Bench, value: int | None) -> None:
    """Answer the last read; the answer is there in the next cycle."""
    request = bench.sent(7)[-1]
    assert isinstance(request, Read)
    bench.report(7, Answer(request.request, value))


def read(bench: Bench, name: str, value: int) -> float:
    """Read an encoder whose register has this value."""
    pending = bench.item(name).value()
    answer(bench, value)
    bench.cycle(7)
    assert isinstance(pending.value, float)
    return pending.value


@pytest.mark.manual("PAML-148")
@pytest.mark.manual("PAML-144")
@pytest.mark.manual("PAMS-032")
def test_a_reading_without_a_sampler_takes_6_cycles(bench: Bench) -> None:
    bench.cycle()
    pending = bench.ask("ENC_Belt", "position")
    assert isinstance(pending, Pending)
    assert bench.sent(7) == [Read(1, 0)]
    assert not bench.ask("ENC_Belt", "ready")
    answer(bench, 16384)
    values = []
    for _ in range(7):
        bench.cycle()
        values.append(pending.value)
    assert values == [None] * 5 + [pytest.approx(90)] * 2
    assert bench.ask("ENC_Belt", "ready")


@pytest.mark.manual("PAML-144")
def test_a_late_answer_is_passed_on_when_it_is_there_and_none_is_a_time_out(bench: Bench) -> None:
    pending = bench.item("ENC_Belt").value()
    bench.cycle(20)
    answer(bench, 16384)
    bench.cycle()
    assert pending.value == pytest.approx(90)
    pending = bench.item("ENC_Belt").value()
    bench.cycle(99)
    values = [pending.value]
    bench.cycle()
    assert [*values, pending.value] == [None, pytest.approx(90)]
    assert bench.kernel.reports == [("07..E021", (7,))]


@pytest.mark.manual("PAML-142")
def test_a_reading_of_a_missing_component_ends_without_a_message() -> None:
    node = "NODES_GROUP NGR_All; NUMBER = 1; END\nNODE NOD_Belt; NODES_GROUP = NGR_All;"
    bench = Bench(ENCODERS.replace("NODE NOD_Belt;", node, 1).replace("SOURCE = AXI_Belt", "SOURCE = ENC_Belt"))
    bench.objects.leave_out([7])
    pending = bench.item("ENC_Belt").value()
    bench.cycle()
    assert (pending.value, bench.kernel.reports, bench.port.sent) == (0, [], [])


@pytest.mark.manual("PAML-140")
@pytest.mark.manual("PAML-141")
@pytest.mark.manual("PAML-149")
def test_units_and_parameters_without_a_period(bench: Bench) -> None:
    assert read(bench, "ENC_Temperature", 16 * 25) == 25
    assert bench.sent(7)[-1] == Read(1, 0xF9 + 0x400)
    assert read(bench, "ENC_Temperature", -32) == -2
    bench.item("ENC_Temperature").set_parameter("PULSES_PER_UNIT", -8)
    assert read(bench, "ENC_Temperature", 16) == -2
    assert read(bench, "ENC_Temperature", 32767) - read(bench, "ENC_Temperature", -32768) == -65535 / 8


@pytest.mark.manual("PAML-146")
@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(-(2**31) + 1, 2**31 - 1), min_size=1, max_size=8))
def test_the_roll_over_of_a_register_does_not_show(ways: list[int]) -> None:
    bench = Bench(ENCODERS)
    count = 0
    read(bench, "ENC_Belt", 0)
    for way in ways:
        count += way
        raw = (count + 2**31) % 2**32 - 2**31
        position = read(bench, "ENC_Belt", raw)
        difference = (position - count / 182.04444444 + 180) % 360 - 180
        assert difference == pytest.approx(0, abs=1e-5)


@pytest.mark.manual("PAML-147")
@pytest.mark.manual("PAMS-011")
def test_position_calls_the_present_position_by_another_name(bench: Bench) -> None:
    read(bench, "ENC_Belt", 16384)
    bench.do("ENC_Belt", "position", 10)
    assert read(bench, "ENC_Belt", 16384 + 8192) == pytest.approx(55)
    bench.item("ENC_Belt").set_parameter("POSITION_PERIOD", 50)
    assert bench.item("ENC_Belt").parameter("POSITION_PERIOD") == 50
    assert read(bench, "ENC_Belt", 16384 + 8192) == pytest.approx(5)


@pytest.mark.manual("PAML-140", "PAMS-034")
def test_speed_is_the_way_since_the_last_reading(bench: Bench) -> None:
    read(bench, "ENC_Belt", 0)
    bench.cycle(3)
    pending = bench.ask("ENC_Belt", "speed")
    answer(bench, 182)
    bench.cycle(7)
    assert pending.value == pytest.approx(1 / 0.010, rel=0.01)  # a degree in 10 cycles


@pytest.mark.manual("PAML-143")
@pytest.mark.manual("PAML-620")
@pytest.mark.manual("PAML-621")
def test_a_sampler_keeps_the_encoder_fresh(bench: Bench) -> None:
    read(bench, "ENC_Belt", 0)
    bench.connect("CNV_Values", "SMP_Belt")
    count = len(bench.port.sent)
    for raw in range(0, 8192, 1024):
        bench.cycle()
        answer(bench, raw)
        bench.cycle()
    assert len(bench.port.sent) - count == 8  # one in each period
    assert bench.ask("SMP_Belt", "value") == pytest.approx(6 * 1024 / 182.0444444)
    assert bench.ask("ENC_Belt", "position") == pytest.approx(7 * 1024 / 182.0444444)  # at once
    bench.do("CNV_Values", "disactivate")
    assert isinstance(bench.ask("ENC_Belt", "position"), Pending)


@pytest.mark.manual("PAML-620")
def test_a_sampler_of_speed(bench: Bench) -> None:
    read(bench, "ENC_Belt", 65536 - 1024)
    bench.connect("CNV_Values", "SMP_Speed")
    values = []
    for step in range(6):
        bench.cycle()
        answer(bench, (65536 + step * 256) % 65536)
        bench.cycle()
        values.append(bench.ask("SMP_Speed", "value"))
    assert values[0] == 0
    assert values[3:] == [pytest.approx(256 / 182.0444444 / 0.002)] * 3


@pytest.mark.manual("PAML-620")
def test_a_sampler_of_an_axis_gives_its_set_position(bench: Bench) -> None:
    bench.connect("CNV_Values", "SMP_Axis")
    bench.cycle()
    assert bench.ask("SMP_Axis", "value") == 5
    assert bench.port.sent == []


@pytest.mark.manual("PAML-142")
def test_an_answer_of_the_register_before_is_not_a_reading_of_another_address(bench: Bench) -> None:
    pending = bench.ask("ENC_Belt", "position")
    bench.item("ENC_Belt").set_parameter("ADDRESS", 1)
    answer(bench, 16384)
    bench.cycle(7)
    assert (pending.value, bench.sent(7)) == (None, [Read(1, 0), Read(2, 1)])
    assert not bench.ask("ENC_Belt", "ready")
    answer(bench, 8192)
    bench.cycle(7)
    assert pending.value == pytest.approx(45, abs=1e-6)
    assert bench.ask("ENC_Belt", "ready")
