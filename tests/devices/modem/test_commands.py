"""The AT commands of a modem: one test for each row of their tables, and what each of them answers.

The results are those of ITU-T V.250, table 1, and of the manual, table 7-1.
"""

import json

import pytest
from modem_bench import ModemBench

from fieldrig_bus.telephone.message import Dial, Heard, Hook, Offer, Ring, Tone
from fieldrig_bus.telephone.modulation import NONE, OPTIONAL, REQUIRED, everything
from fieldrig_devices.modem.commands import COMMANDS, REGISTERS
from fieldrig_devices.modem.extended import PARAMETERS, TEXTS

SETTINGS = [(name, value) for name, row in COMMANDS.items() if row.default is not None for value in row.values]


@pytest.fixture
def bench() -> ModemBench:
    return ModemBench()


@pytest.mark.parametrize(("name", "value"), SETTINGS)
def test_a_setting_is_taken_shown_and_stored(bench: ModemBench, name: str, value: int) -> None:
    shown = bench.ask(f"AT{name}{value}&V&W1")
    assert f"{name}{value}" in shown.split("STORED")[0].split()
    stored = ModemBench(bench.store).ask("AT&V").split("STORED PROFILE 1")[1]
    assert f"{name}{value}" in stored.split()


@pytest.mark.parametrize("name", COMMANDS)
def test_a_value_that_a_command_does_not_have_is_an_error(bench: ModemBench, name: str) -> None:
    assert bench.result(f"AT{name}{max(COMMANDS[name].values) + 1}") == "ERROR"
    assert bench.point("call") == "idle"


@pytest.mark.parametrize("number", REGISTERS)
def test_a_register_takes_its_range_and_no_more(bench: ModemBench, number: int) -> None:
    row = REGISTERS[number]
    assert bench.lines_of(f"ATS{number}?") == [f"{row.default:03d}", "OK"]
    for value in (row.high + 1, row.low - 1):
        if value >= 0:
            assert bench.result(f"ATS{number}={value}") == "ERROR"
    if number not in (2, 3, 4, 5):  # these are the characters of the conversation
        for value in (row.low, row.high):
            assert bench.lines_of(f"ATS{number}={value}S{number}?") == [f"{value:03d}", "OK"]


@pytest.mark.parametrize("name", TEXTS)
def test_an_identification_is_a_text(bench: ModemBench, name: str) -> None:
    assert bench.lines_of(f"AT{name}") == [TEXTS[name], "OK"]
    assert bench.result(f"AT{name}=?") == "OK"


EXTENDED = {
    "+MS": ("+MS=V32B,0,4800,9600", "+MS: V32B,0,4800,9600,0,0",
            "+MS: (V34,V32B,V32,V22B,V22,V21),(0,1),(0,300-33600),(0,300-33600),(0,300-33600),(0,300-33600)"),
    "+IPR": ("+IPR=9600", "+IPR: 9600", "+IPR: (0,300,600,1200,2400,4800,9600,19200,38400,57600,115200,230400)"),
    "+FCLASS": ("+FCLASS=0", "+FCLASS: 0", "+FCLASS: (0)"),
    "+ICF": ("+ICF=5,0", "+ICF: 5,0", "+ICF: (0-6),(0-3)"),
    "+IFC": ("+IFC=1,0", "+IFC: 1,0", "+IFC: (0-3),(0-2)"),
    "+ILRR": ("+ILRR=1", "+ILRR: 1", "+ILRR: (0,1)"),
    "+MR": ("+MR=1", "+MR: 1", "+MR: (0,1)"),
    "+ES": ("+ES=2,2,4", "+ES: 2,2,4", "+ES: (0-3),(0,2,3),(0,1,2,4,5)"),
    "+ER": ("+ER=1", "+ER: 1", "+ER: (0,1)"),
    "+DS": ("+DS=0,0,512,6", "+DS: 0,0,512,6", "+DS: (0-3),(0),(512-2048),(6-250)"),
    "+DR": ("+DR=1", "+DR: 1", "+DR: (0,1)"),
}  # fmt: skip


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_parameter_is_set_read_and_tested(bench: ModemBench, name: str) -> None:
    given, shown, choices = EXTENDED[name]
    assert bench.result(f"AT{given}") == "OK"
    assert bench.lines_of(f"AT{name}?") == [shown, "OK"]
    assert bench.lines_of(f"AT{name}=?") == [choices, "OK"]
    assert bench.result(f"AT{name}=X") == "ERROR"
    assert bench.result(f"AT{name}=1,1,1,1,1,1,1") == "ERROR"
    assert bench.result(f"AT{name}") == "ERROR"


@pytest.mark.parametrize(
    ("rates", "result"),
    [
        ("9600,4800", "ERROR"), ("4800,9600", "OK"), ("9600,9600", "OK"), ("9600,0", "OK"), ("0,9600", "OK"),
        (",,9600,4800", "ERROR"), (",,4800,9600", "OK"), ("9600,33600,300,4800", "ERROR"), ("33600", "OK"),
        ("33601", "ERROR"), ("300,300", "OK"), ("9600,,,4800", "ERROR"),
    ],
)  # fmt: skip
def test_the_lowest_rate_is_not_above_the_highest(bench: ModemBench, rates: str, result: str) -> None:
    before = bench.lines_of("AT+MS?")
    assert bench.result(f"AT+MS=V34,1,{rates}") == result
    assert (bench.lines_of("AT+MS?") == before) is (result == "ERROR")


def test_rates_that_a_later_command_leaves_out_count(bench: ModemBench) -> None:
    assert bench.result("AT+MS=V34,1,9600") == "OK"
    assert bench.result("AT+MS=,,,4800") == "ERROR"
    assert bench.result("AT+MS=,,2400,4800") == "OK"


@pytest.mark.parametrize(
    ("basic", "extended"),
    [
        ("&K0", "+IFC: 0,0"), ("&K3", "+IFC: 2,2"), ("&K4", "+IFC: 1,1"),
        ("\\N0", "+ES: 1,0,1"), ("\\N1", "+ES: 0,0,0"),
        ("\\N2", "+ES: 3,2,4"), ("\\N3", "+ES: 3,0,2"), ("\\N4", "+ES: 3,3,5"),
    ],
)  # fmt: skip
def test_two_commands_of_one_setting_agree(bench: ModemBench, basic: str, extended: str) -> None:
    name, values = extended.split(": ")
    assert bench.lines_of(f"AT{basic}{name}?") == [extended, "OK"]
    fresh = ModemBench()
    assert basic in fresh.ask(f"AT{name}={values};&V").split("STORED")[0].split()


def test_a_memory_without_the_extended_command_has_what_the_basic_one_says() -> None:
    """A profile that an older version has stored."""
    bench = ModemBench()
    bench.ask("AT&K4&W")
    kept = json.loads(bench.store.load() or b"")
    for profile in kept["profiles"]:
        del profile["parameters"]["+IFC"]
    bench.store.save(json.dumps(kept).encode())
    assert ModemBench(bench.store).lines_of("AT+IFC?") == ["+IFC: 1,1", "OK"]


def test_a_call_is_reported_in_the_order_of_v250() -> None:
    """V.250, 6.4.2: modulation before error correction, compression, the serial line, and CONNECT."""
    bench = ModemBench().connected(9600, 1, "ATE0+MR=1;+ER=1;+DR=1;+ILRR=1;DT200")
    reports = ["+MCR: V34", "+MRR: 9600", "+ER: LAPM", "+DR: NONE", "+ILRR: 38400", "CONNECT 9600"]
    assert bench.heard().endswith("".join(f"\r\n{report}\r\n" for report in reports))


def test_reports_have_words_also_with_numeric_results() -> None:
    bench = ModemBench().connected(9600, 0, "ATE0V0+MR=1;+ER=1;DT200")
    assert bench.heard().endswith("DT200\r+MCR: V34\r+MRR: 9600\r+ER: NONE\r12\r")


@pytest.mark.parametrize(
    ("command", "correction"),
    [("+ES=0", NONE), ("+ES=1", NONE), ("+ES=2", OPTIONAL), ("+ES=3", OPTIONAL), ("+ES=3,2", REQUIRED),
     ("+ES=2,3", REQUIRED)],
)  # fmt: skip
def test_es_decides_about_the_correction_of_own_calls(bench: ModemBench, command: str, correction: int) -> None:
    bench.dialled(f"AT{command};DT200").said()
    bench.hear(Offer(everything(), OPTIONAL))
    offers = [message for message in bench.said() if isinstance(message, Offer)]
    assert [offer.correction for offer in offers] == [correction]


@pytest.mark.parametrize(
    ("command", "correction"), [("0", NONE), ("1", NONE), ("2", OPTIONAL), ("4", REQUIRED), ("5", REQUIRED)]
)
def test_es_decides_about_the_correction_of_calls_that_come(bench: ModemBench, command: str, correction: int) -> None:
    bench.ask(f"AT+ES=,,{command}")
    bench.type("ATA\r").wait(3)
    offers = [message for message in bench.said() if isinstance(message, Offer)]
    assert {offer.correction for offer in offers} == {correction}


# ---- actions, and settings with an effect of their own


def test_at_alone_is_ok(bench: ModemBench) -> None:
    assert bench.ask("AT") == "AT\r\r\nOK\r\n"


@pytest.mark.manual("PD-248")
def test_e0_ends_the_echo(bench: ModemBench) -> None:
    bench.ask("ATE0")
    assert bench.ask("AT") == "\r\nOK\r\n"


@pytest.mark.manual("PD-248")
def test_v0_gives_numbers(bench: ModemBench) -> None:
    assert bench.ask("ATE0V0") == "ATE0V0\r0\r"
    assert bench.ask("ATX9") == "4\r"
    assert bench.ask("ATS7?") == "050\r\n0\r"
    assert bench.ask("ATV1") == "\r\nOK\r\n"


@pytest.mark.manual("PD-248")
def test_q1_ends_the_results(bench: ModemBench) -> None:
    assert bench.ask("ATE0Q1") == "ATE0Q1\r"
    assert bench.ask("ATS7?") == "\r\n050\r\n"
    assert bench.ask("ATQ0") == "\r\nOK\r\n"


def test_q2_ends_the_results_of_calls_that_come(bench: ModemBench) -> None:
    bench.ask("ATE0Q2")
    bench.hear(Ring(True))
    assert bench.heard() == ""
    bench.hear(Ring(False)).dialled().hear(Heard(Tone.BUSY)).wait(2)
    assert bench.heard() == "\r\nBUSY\r\n"


def test_i_tells_about_the_modem(bench: ModemBench) -> None:
    assert [bench.lines_of(f"ATI{number}")[-1] for number in range(10)] == ["OK"] * 10
    assert bench.lines_of("ATI3") == ["fieldrig modem", "OK"]


@pytest.mark.manual("PD-248")
def test_and_f_sets_the_factory_defaults(bench: ModemBench) -> None:
    bench.ask("ATX0S7=20+MS=V22;&C0")
    assert bench.result("AT&F") == "OK"
    shown = bench.ask("AT&V").split("STORED")[0]
    assert "X4" in shown.split()
    assert "S07:050" in shown
    assert "+MS=V34,1" in shown
    assert "&C1" in shown.split()


def test_z_sets_a_stored_profile_and_ends_the_line(bench: ModemBench) -> None:
    bench.ask("ATS7=21&W1S7=22&W0S7=30")
    assert bench.lines_of("ATZ1S7=99") == ["OK"]
    assert bench.lines_of("ATS7?") == ["021", "OK"]
    assert bench.lines_of("ATZ") == ["OK"]
    assert bench.lines_of("ATS7?") == ["022", "OK"]


def test_and_y_chooses_the_profile_of_power_on(bench: ModemBench) -> None:
    bench.ask("ATS7=21&W1&Y1")
    assert ModemBench(bench.store).lines_of("ATS7?") == ["021", "OK"]


def test_and_z_has_four_places_for_64_characters(bench: ModemBench) -> None:
    longest = "0" * 64
    assert [bench.result(f"AT&Z{place}={longest}") for place in range(5)] == ["OK"] * 4 + ["ERROR"]
    assert bench.result(f"AT&Z0={longest}1") == "ERROR"
    assert [line for line in bench.lines_of("AT&V") if line.endswith(longest)] == [f"{at}={longest}" for at in range(4)]


def test_and_z_stores_a_number_that_ds_dials(bench: ModemBench) -> None:
    assert bench.result("AT&Z2=06-22 33") == "OK"
    again = ModemBench(bench.store)
    again.ask("ATX0")
    again.said()
    again.type("ATDS=2\r").wait(10)
    assert again.said() == [Hook(True), Dial("062233")]
    again.type("x").wait(1)
    again.heard()
    assert again.result("ATDS=4") == "ERROR"
    assert again.result("ATDS=00000009") == "ERROR"
    again.type("ATDL\r").wait(10)
    assert again.said()[1:] == [Hook(True), Dial("062233")]


def test_h1_seizes_the_line_and_h_leaves_it(bench: ModemBench) -> None:
    assert bench.result("ATH1") == "OK"
    assert bench.said() == [Hook(True)]
    assert bench.result("ATH") == "OK"
    assert bench.said() == [Hook(False)]


def test_o_without_a_call_has_no_carrier(bench: ModemBench) -> None:
    assert bench.result("ATO") == "NO CARRIER"


def test_a_slash_repeats_the_line_at_once(bench: ModemBench) -> None:
    bench.ask("ATE0S7=33S7?")
    assert bench.type("A/").heard() == "\r\n033\r\n\r\nOK\r\n"
    assert bench.type("a/").heard() == "\r\n033\r\n\r\nOK\r\n"


def test_a_register_stays_selected(bench: ModemBench) -> None:
    bench.ask("ATE0S7")
    assert bench.ask("AT=44?") == "\r\n044\r\n\r\nOK\r\n"


def test_s3_and_s4_are_the_characters_of_answers(bench: ModemBench) -> None:
    bench.ask("ATE0")
    bench.type("ATS3=46S4=42\r")
    assert bench.heard() == ".*OK.*"
    assert bench.type("ATS3=13S4=10.").heard() == "\r\nOK\r\n"


# ---- lines of commands


@pytest.mark.manual("PD-247", "PD-248")
def test_the_initialization_string_of_the_manual_is_ok(bench: ModemBench) -> None:
    assert bench.result("AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2") == "OK"
    assert bench.ask("ATS0?") == "\r\n002\r\n\r\nOK\r\n"


@pytest.mark.manual("PD-246")
def test_the_controllers_string_turns_the_echo_off_and_leaves_results_in_words(bench: ModemBench) -> None:
    """E0, Q0 and V1 of `AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2` (4552-4560, 4603-4624), each against its opposite."""
    assert bench.ask("ATE1") == "ATE1\r\r\nOK\r\n"
    bench.ask("AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2")
    assert bench.ask("AT") == "\r\nOK\r\n"
    assert bench.ask("ATS0?") == "\r\n002\r\n\r\nOK\r\n"
    assert bench.ask("ATV0") == "0\r"
    assert bench.ask("ATQ1") == ""
    assert bench.ask("ATQ0V1E1") == "\r\nOK\r\n"
    assert bench.ask("AT") == "AT\r\r\nOK\r\n"


@pytest.mark.manual("PD-249")
def test_the_second_string_turns_automatic_modulation_off(bench: ModemBench) -> None:
    assert bench.result("AT +MS=,0") == "OK"
    assert bench.lines_of("AT+MS?") == ["+MS: V34,0,0,0,0,0", "OK"]


@pytest.mark.manual("PD-270")
def test_another_chip_set_refuses_the_second_string() -> None:
    bench = ModemBench(chip_set="other")
    assert bench.result("AT +MS=,0") == "ERROR"
    assert bench.result("AT") == "OK"


@pytest.mark.parametrize(
    "line",
    ["at", "aTe1q0", "AT  E 1  Q 0", "AT&FE1", "at&f&c1&d2&k3s7=60", "ATS0=0;", "AT+FCLASS=0;+IPR=0;E1", "ATX4L0M0",
     "AT&F&C1&D2S0=0&W", "ATS36=7S48=7S95=0", "ATE1Q0V1X4&C1&D2&K3%C3\\N3", "AT\\N3%C1&Q5", "AT+ipr=0;+ms=v34,1,300"],
)  # fmt: skip
def test_strings_of_usual_drivers_are_ok(bench: ModemBench, line: str) -> None:
    assert bench.result(line) == "OK"


def test_commands_before_a_mistake_are_carried_out_and_those_after_it_are_not(bench: ModemBench) -> None:
    assert bench.result("ATS7=20X9S7=30") == "ERROR"
    assert bench.lines_of("ATS7?") == ["020", "OK"]


def test_backspace_deletes_and_control_characters_are_dropped(bench: ModemBench) -> None:
    bench.ask("ATE0")
    assert bench.type(b"ATS7=5\x0099\x08\x08\x0a5?\x08\r").heard() == "\r\nOK\r\n"
    assert bench.ask("ATS7?") == "\r\n055\r\n\r\nOK\r\n"


def test_parity_bits_do_not_matter(bench: ModemBench) -> None:
    bench.ask("ATE0")
    assert bench.type(bytes(byte | 0x80 for byte in b"ATS7?\r")).heard() == "\r\n050\r\n\r\nOK\r\n"


def test_a_line_that_is_too_long_is_an_error(bench: ModemBench) -> None:
    bench.ask("ATE0")
    assert bench.ask("AT" + "E0" * 127) == "\r\nOK\r\n"
    assert bench.ask("AT" + "E0" * 128) == "\r\nERROR\r\n"
    assert bench.ask("AT") == "\r\nOK\r\n"


@pytest.mark.parametrize("noise", ["", "\r", "hello\r", "AAA", "A", "ATE", "%$!\r\n", "+++"])
def test_what_is_no_command_line_does_not_matter(bench: ModemBench, noise: str) -> None:
    bench.ask("ATE0")
    bench.type(noise).heard()
    bench.type("\r").heard()
    assert bench.ask("AT") == "\r\nOK\r\n"
