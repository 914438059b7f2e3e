"""Outputs, analog output, LEDs with blinking, and the seven-segment display with the codes of the node."""

import pytest
from smart_io_bench import SmartIoBench

from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.frames import AnalogItem, Blink, Display, LedItem, OutputItem, SetOutput, SevenSegmentItem
from fieldrig_devices.smart_io.font import segments_of


@pytest.mark.manual("PAML-100")
@pytest.mark.manual("PAML-101")
@pytest.mark.parametrize(("is_active_high", "inactive"), [(True, False), (False, True)])
def test_an_output_begins_inactive_and_takes_electrical_levels(is_active_high: bool, inactive: bool) -> None:
    bench = SmartIoBench()
    bench.configure(OutputItem(7, 105, 1, is_active_high))
    assert bench.last("valve") is inactive
    bench.order(SetOutput(7, int(not inactive)))
    assert bench.last("valve") is not inactive
    bench.program.forget()
    assert bench.last("valve") is inactive


@pytest.mark.manual("PAML-102")
def test_6_bits_at_201_are_outputs_1_to_6_of_module_2() -> None:
    bench = SmartIoBench()
    bench.configure(OutputItem(7, 201, 6, True))
    bench.order(SetOutput(7, 0b100101))
    assert [address for address in range(201, 213) if bench.get(f"out{address}")] == [201, 203, 206]


@pytest.mark.manual("PAML-103")
def test_the_analog_output_is_in_millivolts_and_saturates() -> None:
    bench = SmartIoBench()
    bench.configure(AnalogItem(7, 1))
    for millivolts, volts in ((2500, 2.5), (-10_000, -10.0), (12_000, 10.0)):
        bench.order(SetOutput(7, millivolts))
        assert bench.last("speed") == volts
    assert bench.get("error_word") == 0
    bench.program.forget()
    assert bench.last("speed") == 0


@pytest.mark.manual("PAML-108")
@pytest.mark.manual("PAMS-043")
def test_set_and_reset_switch_an_led() -> None:
    bench = SmartIoBench()
    bench.configure(LedItem(7, 6))
    bench.order(SetOutput(7, 1))
    assert bench.last("lamp") is True
    bench.order(SetOutput(7, 0))
    assert bench.last("lamp") is False


@pytest.mark.manual("PAML-104")
@pytest.mark.manual("PAMS-041")
def test_an_led_blinks_in_the_node_and_returns_to_steady_on() -> None:
    """Case T13: set, blink, five seconds, no_blink."""
    bench = SmartIoBench()
    bench.configure(LedItem(7, 6))
    bench.run(730)
    bench.order(SetOutput(7, 1), Blink(7, True))
    levels = []
    for _ in range(10):
        bench.run(250)
        levels.append((bench.last("lamp"), bench.get("led6")))
        bench.run(250)
    assert levels == [(True, True), (False, False)] * 5
    bench.order(Blink(7, False))
    bench.run(1_750)
    assert bench.last("lamp") is True
    assert bench.clock.next_ns() is None
    assert bench.get("error_word") == 0


@pytest.mark.manual("PAMS-043")
def test_an_led_follows_a_program_that_inverts_it_every_500_ms() -> None:
    """Case T15."""
    bench = SmartIoBench()
    bench.configure(LedItem(7, 6))
    bench.wires.take()
    for value in (1, 0, 1, 0):
        bench.order(SetOutput(7, value))
        bench.run(500)
    assert [signal.value for signal in bench.wires.take()] == [True, False, True, False]


@pytest.mark.manual("PAML-105")
@pytest.mark.manual("PAMS-042")
@pytest.mark.parametrize(("character", "segments"), [("P", "abefg"), ("7", "abc"), ("8", "abcdefg"), ("4", "bcfg")])
def test_the_display_shows_a_character(character: str, segments: str) -> None:
    """Case T14: display("P"), 7, 8000/1000 and 4660, whose last hexadecimal digit is 4."""
    bench = SmartIoBench()
    bench.configure(SevenSegmentItem(7, 1, 1))
    bench.order(Display(7, ord(character)))
    assert (bench.get("display"), bench.get("display.segments")) == (character, segments)
    assert (bench.get("display.blink"), bench.get("error_word")) == (False, 0)


@pytest.mark.manual("PAMS-041")
def test_the_display_blinks_its_present_character() -> None:
    bench = SmartIoBench()
    bench.configure(SevenSegmentItem(7, 1, 1))
    bench.run(300)
    bench.order(Display(7, ord("A")), Blink(7, True))
    assert (bench.get("display.blink"), bench.get("error_word")) == (True, 0)
    shown = []
    for _ in range(4):
        shown.append(bench.get("display.segments"))
        bench.run(500)
    assert shown == ["abcefg", "", "abcefg", ""]
    bench.order(Blink(7, False))
    bench.run(700)
    assert bench.get("display.segments") == "abcefg"


@pytest.mark.manual("PAMS-109")
def test_the_font_draws_digits_and_letters_and_has_nothing_outside_of_it() -> None:
    assert segments_of(0x20) == segments_of(31) == segments_of(128) == ""
    assert {segments_of(ord(digit)) for digit in "0123456789"} == {
        "abcdef", "bc", "abdeg", "abcdg", "bcfg", "acdfg", "acdefg", "abc", "abcdefg", "abcdfg",
    }  # fmt: skip
    assert [segments_of(ord(one)) for one in "abdef"] == [segments_of(ord(one)) for one in "ABDEF"]
    assert segments_of(ord("-")) == "g"


@pytest.mark.manual("PAMS-112")
def test_the_display_shows_how_far_the_configuration_is() -> None:
    bench = SmartIoBench()
    bench.program.attach(bench.port)
    assert (bench.get("display"), bench.get("display.blink")) == ("F 4", True)
    bench.program.forget()
    assert (bench.get("display"), bench.get("display.blink")) == ("8.", False)
    assert bench.get("display.segments") == "abcdefgp"
    bench.program.run()
    assert bench.get("display") == " "


@pytest.mark.manual("PAMS-112")
@pytest.mark.parametrize(
    ("fault", "code"), [(RingFault.INACTIVE, "F 2"), (RingFault.CARRIER, "F-6"), (RingFault.CRC, "F-7")]
)
def test_the_display_shows_what_is_wrong_with_the_ring(fault: RingFault, code: str) -> None:
    bench = SmartIoBench()
    bench.configure()
    bench.program.ring(fault)
    assert (bench.get("display"), bench.get("ring_leds")) == (code, code != "F 2")
    bench.program.ring(RingFault.NONE)
    assert bench.get("display") == " "


def test_one_digit_shows_a_code_character_by_character() -> None:
    bench = SmartIoBench()
    bench.configure()
    bench.program.ring(RingFault.CARRIER)
    shown = []
    for _ in range(5):
        shown.append(bench.get("display.segments"))
        bench.run(500)
    assert shown == ["aefg", "g", "acdefg", "", "aefg"]


@pytest.mark.parametrize(("setting", "valve"), [("inactive", False), ("hold", True)])
def test_outputs_of_a_silent_ring_are_as_the_settings_say(setting: str, valve: bool) -> None:
    bench = SmartIoBench(outputs_without_ring=setting)
    bench.configure(OutputItem(7, 105, 1, True))
    bench.order(SetOutput(7, 1))
    bench.program.ring(RingFault.INACTIVE)
    assert bench.last("valve") is valve
