"""Inputs, outputs and displays of an application, and the configuration of their nodes."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.pamring import frames

SAMPLED = "PERIOD = 10; DEBOUNCE = 2; END\n"
DESK = (
    HEADER
    + """
NODES_GROUP NGR_Stations; NUMBER = 3; END
NODE NOD_Desk; ADDRESS = 41; TYPE = SMART_IO; END
NODE NOD_Station; NODES_GROUP = NGR_Stations; ADDRESS = 63; TYPE = SMART_IO; END
BINARY_OUTPUT SBO_Inc; NODE = NOD_Desk; ADDRESS = 101; ACTIVE = HIGH; END
BINARY_OUTPUT SBO_Dec; NODE = NOD_Desk; ADDRESS = 102; ACTIVE = LOW; END
"""
    + f"BINARY_INPUT SBI_Zero; NODE = NOD_Desk; ADDRESS = 102; ACTIVE = LOW; {SAMPLED}"
    + "COUNTER_INPUT CNT_Pulses; NODE = NOD_Desk; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END\n"
    + f"DIGITAL_INPUT SDI_Code; NODE = NOD_Desk; BITS = 5; ADDRESS = 208; ACTIVE = LOW; {SAMPLED}"
    + """
KEY_INPUT KEY_Slow; NODE = NOD_Desk; MODE = AUTOREPEAT; DELAY = 1500; REPEAT = 500; ADDRESS = 18; ACTIVE = HIGH;
  PERIOD = 20; END
DIGITAL_OUTPUT SDO_Code; NODE = NOD_Desk; BITS = 6; ADDRESS = 201; ACTIVE = LOW; END
ANALOG_OUTPUT SAO_Speed; NODE = NOD_Desk; RANGE = -10000 10000; ADDRESS = 1; END
LED_OUTPUT LED_Run; NODE = NOD_Desk; ADDRESS = 6; END
D7SEG_OUTPUT D7S_Digit; NODE = NOD_Desk; DIGITS = 1; ADDRESS = 1; END
DC_MOTOR DCM_Width; INC = SBO_Inc; DEC = SBO_Dec; ZERO = SBI_Zero; ENCODER = CNT_Pulses; TIMEOUT = 500;
  BRAKING = 3; END
BINARY_OUTPUT SBO_Each; NODE = NOD_Station; ADDRESS = 301; ACTIVE = HIGH; END
INTERNAL FLAG_VAR IFV_Each; NODES_GROUP = NGR_Stations; END
PAM_ANALOG_OUTPUT PAO_Probe; UNITS_PER_VOLT = 1000; OFFSET = 0; ADDRESS = 0; END
PAM_ANALOG_OUTPUT PAO_Both; UNITS_PER_VOLT = 10000; OFFSET = 12500; ADDRESS = 1; END
"""
)


@pytest.fixture
def volts() -> dict[int, float]:
    return {}


@pytest.fixture
def bench(volts: dict[int, float]) -> Bench:
    return Bench(DESK, volts=volts.__setitem__)


def item(bench: Bench, kind: type) -> int:
    """The number of the first item of a kind on the desk."""
    found: int = next(item.item for item in bench.objects.nodes[0].items if isinstance(item, kind))
    return found


@pytest.mark.manual("PAML-080")
@pytest.mark.manual("PAML-022")
def test_each_node_is_configured_with_its_items(bench: Bench) -> None:
    desk, *stations = bench.objects.nodes
    assert desk.items == [
        frames.OutputItem(1, 101, 1, True),
        frames.OutputItem(2, 102, 1, False),
        frames.InputItem(3, 102, 1, False, 10, 2),
        frames.CounterItem(4, 101, True, 1, 1),
        frames.InputItem(5, 208, 5, False, 10, 2),
        frames.KeyItem(6, 18, False, frames.KeyMode.AUTOREPEAT, 20, 1500, 500),
        frames.OutputItem(7, 201, 6, False),
        frames.AnalogItem(8, 1),
        frames.LedItem(9, 6),
        frames.SevenSegmentItem(10, 1, 1),
        frames.MotorItem(11, increase=1, decrease=2, zero=3, counter=4, timeout_ms=500, braking=3),
    ]
    assert [(node.address, node.items) for node in stations] == [
        (address, [frames.OutputItem(1, 301, 1, True)]) for address in (63, 64, 65)
    ]


@pytest.mark.manual("PAML-007")
def test_a_component_with_a_missing_node_is_ignored(bench: Bench) -> None:
    bench.objects.leave_out([64])
    for index in range(3):
        bench.item("SBO_Each", index).do("set")
    assert [address for address, _ in bench.port.sent] == [63, 65]
    names = ("SBO_Each", "IFV_Each", "NOD_Station", "NGR_Stations")
    assert [[bench.objects.is_active(name, index) for index in range(3)] for name in names] == [[True, False, True]] * 4
    assert bench.objects.is_active("SBO_Inc", 1)


@pytest.mark.manual("PAML-081")
@pytest.mark.manual("PAML-084")
@pytest.mark.manual("PAML-093")
def test_a_low_level_of_an_input_that_is_active_low_is_true(bench: Bench) -> None:
    bench.change(41, 3, 0)
    assert bench.item("SBI_Zero").value() is True
    assert bench.kernel.touched_names == {"SBI_Zero"}
    bench.change(41, 3, 1)
    assert bench.item("SBI_Zero").value() is False


@pytest.mark.manual("PAML-085")
def test_a_digital_input_has_the_lowest_address_in_its_lowest_bit(bench: Bench) -> None:
    bench.change(41, 5, 0b00000)
    assert bench.item("SDI_Code").value() == 31
    bench.change(41, 5, 0b11110)
    assert bench.item("SDI_Code").value() == 1


@pytest.mark.manual("PAML-086")
def test_a_counter_counts(bench: Bench) -> None:
    bench.change(41, 4, 1234)
    assert bench.item("CNT_Pulses").value() == 1234


@pytest.mark.manual("PAML-092")
def test_a_program_writes_a_key_until_the_key_changes(bench: Bench) -> None:
    key = bench.item("KEY_Slow")
    key.do("set")
    assert (key.value(), bench.sent(41)) == (True, [frames.SetOutput(6, 1, number=1)])
    key.do("invert")
    assert key.value() is False
    bench.objects.on_report(41, frames.InputChanged(6, 1, number=2))
    assert key.value() is True
    key.do("reset")
    assert bench.sent(41)[-1] == frames.SetOutput(6, 0, number=3)


@pytest.mark.manual("PAML-092")
def test_a_key_that_the_node_has_pressed_before_does_not_undo_what_a_program_has_written(bench: Bench) -> None:
    key = bench.item("KEY_Slow")
    key.do("reset")
    bench.change(41, 6, 1)  # pressed before the order
    assert key.value() is False
    bench.objects.on_report(41, frames.InputChanged(6, 0, number=1))
    assert key.value() is False


def test_a_key_whose_node_has_lost_an_order_is_heard_again_after_the_time_out_of_a_reading(bench: Bench) -> None:
    key = bench.item("KEY_Slow")
    key.do("reset")
    bench.cycle(99)
    bench.change(41, 6, 1)
    assert key.value() is False
    bench.cycle()
    bench.change(41, 6, 1)
    assert key.value() is True


@pytest.mark.manual("PAML-101")
@pytest.mark.manual("PAML-108")
def test_outputs_are_sent_when_they_change(bench: Bench) -> None:
    output = bench.item("SBO_Dec")
    output.do("reset")
    output.do("set")
    output.set_value(True)
    assert (bench.sent(41), output.value()) == ([frames.SetOutput(2, 0)], True)
    output.do("invert")
    assert (bench.sent(41)[-1], output.value()) == (frames.SetOutput(2, 1), False)
    assert bench.kernel.touched_names == {"SBO_Dec"}


@pytest.mark.manual("PAML-102")
def test_a_digital_output_drops_bits_that_it_does_not_have(bench: Bench) -> None:
    output = bench.item("SDO_Code")
    output.set_value(63.9)
    assert (bench.sent(41), output.value()) == ([frames.SetOutput(7, 0)], 63)
    output.set_value(64 + 5)
    assert (bench.sent(41)[-1], output.value()) == (frames.SetOutput(7, 0b111010), 5)


@pytest.mark.manual("PAML-103")
@pytest.mark.parametrize(("value", "millivolts"), [(1245, 1245), (-10000, -10000), (12000, 10000), (-99999, -10000)])
def test_an_analog_output_is_linear_and_limited(bench: Bench, value: float, millivolts: int) -> None:
    bench.item("SAO_Speed").set_value(value)
    assert bench.sent(41) == [frames.SetOutput(8, millivolts)]


@pytest.mark.manual("PAML-104")
@pytest.mark.manual("PAMS-041")
def test_a_led_blinks_in_its_node(bench: Bench) -> None:
    for function in ("set", "blink", "no_blink", "reset"):
        bench.do("LED_Run", function)
    assert bench.sent(41) == [
        frames.SetOutput(9, 1),
        frames.Blink(9, True),
        frames.Blink(9, False),
        frames.SetOutput(9, 0),
    ]


@pytest.mark.manual("PAML-105")
@pytest.mark.manual("PAMS-042")
@pytest.mark.parametrize(
    ("arguments", "shown"), [(("P",), "P"), ((7, 1), "7"), ((8000 / 1000, 1), "8"), ((4660, 1), "4"), ((15, 1), "F")]
)
def test_a_display_shows_characters_and_lowest_digits(bench: Bench, arguments: tuple[object, ...], shown: str) -> None:
    bench.do("D7S_Digit", "display", *arguments)
    bench.do("D7S_Digit", "blink")
    assert bench.sent(41) == [frames.Display(10, ord(shown)), frames.Blink(10, True)]


@pytest.mark.manual("PAML-106")
@pytest.mark.parametrize(
    ("name", "value", "volt"),
    [
        ("PAO_Probe", 1245.38, 1.245),
        ("PAO_Both", -12500, 0.0),
        ("PAO_Both", 0, 1.25),
        ("PAO_Both", 12500, 2.5),
        ("PAO_Both", 99999, 2.5),
        ("PAO_Both", -99999, 0.0),
    ],
)
def test_analog_outputs_of_the_pam(bench: Bench, volts: dict[int, float], name: str, value: float, volt: float) -> None:
    address = 0 if name == "PAO_Probe" else 1
    bench.item(name).set_value(value)
    assert volts.get(address, 0.0) == pytest.approx(volt, abs=2.5 / 255 / 2 + 1e-3)
    assert volts.get(address, 0.0) * 255 / 2.5 == pytest.approx(round(volts.get(address, 0.0) * 255 / 2.5))


@pytest.mark.manual("PAML-122")
@pytest.mark.manual("PAML-125")
@pytest.mark.manual("PAML-127")
@pytest.mark.parametrize(
    ("function", "arguments", "order"),
    [
        ("absolute_move", (100.7,), frames.MotorOrder(11, frames.Motor.ABSOLUTE_MOVE, (100,), number=1)),
        ("relative_move", (-5,), frames.MotorOrder(11, frames.Motor.RELATIVE_MOVE, (-5,), number=1)),
        ("run", ("DEC",), frames.MotorOrder(11, frames.Motor.RUN, (-1,), number=1)),
        ("stop", (), frames.MotorOrder(11, frames.Motor.STOP, number=1)),
        ("position", (7,), frames.MotorOrder(11, frames.Motor.POSITION, (7,))),
        ("zero_position", ("INC", "LOW"), frames.MotorOrder(11, frames.Motor.ZERO_POSITION, (1, 0), number=1)),
        ("stroke_limits", (-10, 500), frames.MotorOrder(11, frames.Motor.STROKE_LIMITS, (-10, 500))),
        ("disable_stroke_limits", (), frames.MotorOrder(11, frames.Motor.DISABLE_STROKE_LIMITS)),
    ],
)
def test_orders_to_a_motor(
    bench: Bench, function: str, arguments: tuple[object, ...], order: frames.MotorOrder
) -> None:
    bench.do("DCM_Width", function, *arguments)
    assert bench.sent(41) == [order]


@pytest.mark.manual("PAML-129")
@pytest.mark.manual("PAMS-053")
def test_a_motor_is_ready_when_its_node_says_so(bench: Bench) -> None:
    assert bench.ask("DCM_Width", "ready")
    bench.do("DCM_Width", "absolute_move", 100)
    assert not bench.ask("DCM_Width", "ready")
    bench.objects.on_report(41, frames.MotorReport(11, is_ready=True, error=0x4, number=1))
    assert bench.ask("DCM_Width", "ready")
    assert bench.ask("DCM_Width", "error")
    assert [bench.ask("DCM_Width", "error_code", mask) for mask in (0x7, 0x3)] == [True, False]
    assert bench.ask("DCM_Width", "error_code") == 0x4


@pytest.mark.manual("PAML-129")
def test_a_state_from_before_an_order_is_not_that_of_the_order(bench: Bench) -> None:
    bench.do("DCM_Width", "run", "INC")
    bench.do("DCM_Width", "absolute_move", 100)
    bench.objects.on_report(41, frames.MotorReport(11, is_ready=True, error=0x1, number=1))
    assert [bench.ask("DCM_Width", name) for name in ("ready", "error")] == [False, False]
    bench.objects.on_report(41, frames.MotorReport(11, is_ready=True, error=0x4, number=2))
    assert [bench.ask("DCM_Width", name) for name in ("ready", "error_code")] == [True, 0x4]


@pytest.mark.manual("PAMS-053")
def test_an_order_to_move_ends_all_errors_but_the_lost_position_and_a_stop_ends_none(bench: Bench) -> None:
    bench.objects.on_report(41, frames.MotorReport(11, is_ready=True, error=0x6000))
    bench.do("DCM_Width", "stop")
    assert bench.ask("DCM_Width", "error_code") == 0x6000
    bench.do("DCM_Width", "run", "INC")
    assert bench.ask("DCM_Width", "error_code") == 0x2000


@pytest.mark.manual("PAML-128")
def test_the_position_of_a_motor_is_read_over_the_ring(bench: Bench) -> None:
    bench.cycle()
    pending = bench.ask("DCM_Width", "position")
    (read,) = bench.sent(41)
    assert read == frames.Read(1, 11)
    bench.cycle()
    values = [pending.value]
    bench.report(41, frames.Answer(1, -42))
    bench.cycle()
    assert [*values, pending.value] == [None, -42]
    assert not bench.kernel.reports


@pytest.mark.manual("PAML-128")
def test_a_motor_that_does_not_answer_is_in_error(bench: Bench) -> None:
    pending = bench.ask("DCM_Width", "position")
    bench.cycle(100)
    assert pending.value == 0
    assert bench.ask("DCM_Width", "error_code") == 0x8
    assert bench.kernel.reports == [("07..E021", (41,)), ("04..W010", (41, 11, 0x12))]


@pytest.mark.manual("PAML-024", "PAML-025", "PAMS-051")
def test_the_error_word_of_a_node(bench: Bench) -> None:
    bench.objects.on_report(41, frames.Trouble(frames.Severity.WARNING, 0x00C, (0x08, 0), 0x001000))
    assert bench.kernel.touched_names == {"NOD_Desk"}
    assert bench.ask("NOD_Desk", "error")
    assert bench.ask("NOD_Desk", "error_code") == 0x001000
    assert [bench.ask("NOD_Desk", "error_code", mask) for mask in (0x001000, 0x000FF0)] == [True, False]
    bench.objects.on_report(41, frames.Trouble(frames.Severity.ENDED, 0x00C, (0x08, 0)))
    assert not bench.ask("NOD_Desk", "error")


@pytest.mark.manual("PAML-024")
def test_an_st1_has_no_error_word_of_a_node() -> None:
    bench = Bench(HEADER + "NODE NOD_Belt; ADDRESS = 7; TYPE = ST1; END\n")
    bench.objects.on_report(7, frames.Trouble(frames.Severity.WARNING, 0x00C, (0x08, 0), 0x001000))
    assert not bench.ask("NOD_Belt", "error")


@pytest.mark.manual("PAML-023")
@pytest.mark.parametrize("address", ["41", "#29"])
def test_an_address_is_decimal_without_a_number_sign(address: str) -> None:
    bench = Bench(HEADER + f"NODE NOD_Desk; ADDRESS = {address}; TYPE = SMART_IO; END\n")
    bench.objects.on_report(41, frames.Trouble(frames.Severity.WARNING, 0x00C, (0x08, 0), 0x001000))
    assert bench.ask("NOD_Desk", "error")


NUMBERS = st.integers(-(2**31), 2**32)
REPORTS = st.one_of(
    st.builds(frames.InputChanged, st.integers(0, 14), NUMBERS, st.integers(0, 2**32 - 1)),
    st.builds(frames.MotorReport, st.integers(0, 14), st.booleans(), NUMBERS, st.integers(0, 2)),
    st.builds(frames.AxisReport, NUMBERS, NUMBERS, st.integers(0, 65535), NUMBERS),
    st.builds(frames.Answer, st.integers(0, 5), st.none() | NUMBERS),
    st.builds(frames.Trouble, st.sampled_from(frames.Severity), NUMBERS, st.tuples(NUMBERS, NUMBERS), NUMBERS),
)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.sampled_from([41, 63, 7, 99]), REPORTS), max_size=12))
def test_no_report_of_a_node_stops_the_pam(reports: list[tuple[int, frames.Report]]) -> None:
    axis = "NODE NOD_a; ADDRESS = 7; TYPE = ST1; END AXIS AXI_a; NODE = NOD_a; PULSES_PER_UNIT = 3; TRAVEL_SPEED = 1;"
    bench = Bench(f"{DESK}{axis} ACCELERATION = 1; INITIAL_POSITION = 0; POSITION_PERIOD = 360; END")
    bench.do("AXI_a", "run", 1)
    bench.do("DCM_Width", "run", "INC")
    bench.ask("DCM_Width", "position")
    for address, report in reports:
        bench.objects.on_report(address, report)
        bench.cycle()
    assert isinstance(bench.ask("AXI_a", "error_code"), int)


def test_reports_on_unknown_nodes_and_items_are_dropped(bench: Bench) -> None:
    bench.change(99, 1, 1)
    bench.change(41, 99, 1)
    bench.objects.on_report(41, frames.Answer(77, 1))
    bench.cycle()
    assert bench.kernel.touched_names == set()
