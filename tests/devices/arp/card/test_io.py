"""The card's own terminals on wires (digest 9; manual 3.1)."""

import pytest
from arp_bench import CardBench

from fieldrig.clock import MS
from fieldrig.errors import ControlError
from fieldrig_bus.wires import Motion, Signal

LOOP = "LOOP:\nGOTO LOOP"
ENCODER_ONLY = {"axis1": {1: 2}, "axis2": {1: 4}}


@pytest.mark.manual("ARP-036")
def test_each_digital_input_is_a_wire() -> None:
    bench = CardBench(LOOP)
    for number in range(101, 109):
        for level in (True, False):
            bench.drive(f"I{number}", level).run_for(1)
            assert bench.access.I[number] == level
            assert sum(bench.access.I[101:108]) == (level if number < 108 else 0)


@pytest.mark.manual("ARP-036")
def test_inputs_are_sampled_once_a_control_loop() -> None:
    bench = CardBench(LOOP, {"general": {1: 5}}).run_for(20)
    bench.drive("I101", True).run_for(4)
    assert bench.get("I101") is True
    assert bench.access.I[101] == 0
    bench.run_for(1)
    assert bench.access.I[101] == 1
    bench.drive("I101", False).run_for(2).drive("I101", True).run_for(3)
    assert bench.access.I[101] == 1  # too short to be seen


@pytest.mark.manual("ARP-037")
def test_each_digital_output_is_a_wire_that_carries_its_changes() -> None:
    bench = CardBench(
        "SET O101\nSET O103\nSET O105\nWAIT 0.01\nSET O101\nRES O103\nSET O232\n" + LOOP, is_enabled=False
    )
    assert [signal.name for signal in bench.wires.take()] == [
        *(f"card1.O{number}" for number in range(101, 105)),
        "card1.dac1",
        "card1.dac2",
    ]  # all outputs at first
    bench.drive("I108", True).run_for(50)
    assert [(signal.name, signal.value) for signal in bench.wires.take()] == [
        ("card1.O101", True),
        ("card1.O103", True),
        ("card1.O103", False),
    ]


def test_analog_wires_are_in_volts() -> None:
    bench = CardBench("V3 == ADC 3\nV5 == ADC 5\nDAC 2, -2.5\n" + LOOP).drive("adc3", -1.25).drive("adc5", 10.0)
    bench.run_for(20)
    assert (bench.variable(3), bench.variable(5), bench.last_sent("dac2")) == (-1.25, 10.0, -2.5)
    assert bench.wires.sent[-1] == Signal("card1.dac2", -2.5, "V")


def test_a_wire_in_another_unit_is_not_taken(caplog: pytest.LogCaptureFixture) -> None:
    bench = CardBench(LOOP)
    for _ in range(2):
        bench.wires.deliver(Signal("card1.adc3", 5.0, "mV"))
    assert bench.get("adc3") == 0.0
    assert [record.message for record in caplog.records] == [
        "card1.adc3 has the unit 'mV', but adc3 has 'V'; the signal is ignored"
    ]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e300])
@pytest.mark.parametrize("terminal", ["adc1", "adc3", "encoder1", "I101"])
def test_no_number_on_a_wire_harms(terminal: str, value: float) -> None:
    bench = CardBench("LOOP:\nV1 == ADC 1\nGOTO LOOP", {"general": {2: 1}}).run_for(20)
    assert bench.drive(terminal, value).run_for(20).state == 3


def test_a_motion_beyond_all_bounds_does_no_harm() -> None:
    bench = CardBench(LOOP, ENCODER_ONLY).run_for(20)
    bench.wires.deliver(Motion("card1.encoder1", 0.0, "count", 0, 1e308, 1e308))
    assert bench.run_for(200).state == 3


@pytest.mark.manual("ARP-001")
def test_an_encoder_moves_on_by_itself() -> None:
    bench = CardBench(LOOP, ENCODER_ONLY).drive("encoder2", 0).run_for(10)
    bench.wires.deliver(Motion("card1.encoder2", 0, "count", 10 * MS, speed=4_000.0))
    bench.run_for(100)
    assert bench.position(2) == 100.0  # 400 counts, 4 a unit
    assert bench.get("axis2.speed") == 1_000.0
    assert bench.position(1) == 0.0


def test_a_counter_sees_whole_counts_only() -> None:
    bench = CardBench(LOOP, {"axis1": {1: 1}}).drive("encoder1", 0).run_for(2)
    for counts, position in ((0.999, 0.0), (1.0, 1.0), (-0.001, -1.0)):
        assert bench.drive("encoder1", counts).run_for(1).position(1) == position


@pytest.mark.parametrize(("latch1", "level_of"), [("I101", "I101"), ("I105", "I105")])
def test_a_latch_input_captures_the_position(latch1: str, level_of: str) -> None:
    bench = CardBench("SET F265\nLOOP:\nV1 == #LQOSP1\nGOTO LOOP", latch1=latch1).drive("encoder1", 0).run_for(20)
    bench.drive("encoder1", 42).run_for(5).drive(level_of, True).run_for(5)
    assert (bench.variable(1), bench.access.F[265]) == (42, 0)


def test_signals_rename_wires() -> None:
    signals = {"I101": "panel.start", "O101": "lamp", "encoder1": "spindle.encoder"}
    bench = CardBench("LOOP:\nO101 == I101\nGOTO LOOP", signals=signals)
    bench.wires.deliver(Signal("panel.start", True))
    bench.wires.deliver(Signal("spindle.encoder", 7, "count"))
    bench.run_for(20)
    assert Signal("lamp", True) in bench.wires.sent
    assert bench.get("axis1.position") == 7.0
    assert {"panel.start", "spindle.encoder", "card1.I102"} <= set(bench.wires.interest or ())


def test_one_wire_may_go_to_several_inputs() -> None:
    """Both counters read the same encoder; a button starts and latches."""
    signals = {"encoder1": "line.encoder", "encoder2": "line.encoder", "I101": "button", "I103": "button"}
    bench = CardBench(LOOP, signals=signals)
    bench.wires.deliver(Signal("line.encoder", 7, "count"))
    bench.wires.deliver(Signal("button", True))
    bench.run_for(20)
    assert (bench.position(1), bench.position(2)) == (7, 7)
    assert bench.access.I[101:104] == [1, 0, 1]


def test_an_input_without_a_wire_feels_what_the_rig_file_or_a_person_says() -> None:
    bench = CardBench(
        "LOOP:\nV1 == ADC 1\nGOTO LOOP", {"general": {2: 1}}, inputs={"I108": True, "I102": 1, "adc1": 0.001}
    )
    bench.run_for(50)
    assert (bench.access.I[102], bench.variable(1)) == (1, 1_000)  # microvolts
    bench.set("I102", False)
    bench.set("adc1", 0.002)
    bench.set("encoder1", 12)
    bench.run_for(1_000)
    assert (bench.access.I[102], bench.variable(1), bench.position(1)) == (0, 2_000, 12.0)
    assert (bench.get("adc1"), bench.get("encoder1"), bench.get("adc1.read")) == (0.002, 12, 2_000.0)


def test_an_input_with_a_wire_feels_the_wire() -> None:
    bench = CardBench(LOOP).drive("I102", True)
    with pytest.raises(ControlError, match=r"card1\.I102 drives I102"):
        bench.set("I102", False)


@pytest.mark.long
@pytest.mark.parametrize(
    ("key", "value"), [("I101", 2), ("I101", "x"), ("adc1", True), ("encoder1", "x"), ("dac1", 1.0)]
)
def test_wrong_values_are_refused_with_a_word(key: str, value: bool | float | str) -> None:
    with pytest.raises(ControlError):
        CardBench(LOOP).set(key, value)


def test_a_card_without_wires_runs_on_its_points() -> None:
    bench = CardBench("SET O101\n" + LOOP)
    assert bench.run_for(20).get("O101") is True
