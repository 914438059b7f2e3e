"""Calls of one modem: what a dial string makes it do, what it answers, and when (ITU-T V.250, 6.3)."""

import pytest
from modem_bench import ModemBench

from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Offer, Ready, Ring, TelephoneMessage, Tone
from fieldrig_bus.telephone.modulation import Modulation, everything

DIAL_TONE, BUSY, RINGING, SILENCE = Heard(Tone.DIAL), Heard(Tone.BUSY), Heard(Tone.RINGING), Heard(Tone.SILENCE)


@pytest.fixture
def bench() -> ModemBench:
    bench = ModemBench()
    bench.ask("ATE0")
    return bench


def dials(bench: ModemBench, command: str) -> list[TelephoneMessage]:
    """Return what the exchange gets when it gives its dial tone at once."""
    bench.type(command + "\r").hear(DIAL_TONE).wait(30)
    return bench.said()


# ---- dial strings, a row each: the string, what the exchange gets, and the seconds from the command on

STRINGS = [
    ("ATDT200", [Hook(True), Dial("200")], 1.57),  # 1 s of dial tone, and 95 ms twice for each digit
    ("ATD200", [Hook(True), Dial("200")], 1.57),
    ("atdt 2-0(0)", [Hook(True), Dial("200")], 1.57),
    ("ATDP12", [Hook(True), Dial("12")], 2.7),  # 100 ms a pulse, and 700 ms after each digit
    ("ATDT1P0", [Hook(True), Dial("1"), Dial("0")], 2.89),
    ("ATDT0,1", [Hook(True), Dial("0"), Dial("1")], 3.38),  # S8 is 2 s
    ("ATS8=5DT0,,1", [Hook(True), Dial("0"), Dial("1")], 11.38),
    ("ATX3DT1", [Hook(True), Dial("1")], 2.19),  # S6 is 2 s
    ("ATX3S6=5DT1", [Hook(True), Dial("1")], 5.19),
    ("ATDT1!2", [Hook(True), Dial("1"), Hook(False), Hook(True), Dial("2")], 1.88),
    ("ATS11=50DT200", [Hook(True), Dial("200")], 1.3),
    ("ATDT*12#A", [Hook(True), Dial("*12#A")], 1.95),
]


@pytest.mark.parametrize(("command", "expected", "seconds"), STRINGS)
def test_a_dial_string_is_dialled(
    bench: ModemBench, command: str, expected: list[TelephoneMessage], seconds: float
) -> None:
    bench.type(command + "\r").hear(DIAL_TONE)
    bench.wait(seconds - 0.001)
    assert bench.telephone.sent == expected[:-1]
    bench.wait(0.002)
    assert bench.said() == expected


def test_w_waits_for_the_second_dial_tone(bench: ModemBench) -> None:
    bench.type("ATDT0W1\r").hear(DIAL_TONE).wait(1.5).hear(SILENCE).wait(10)
    assert bench.said() == [Hook(True), Dial("0")]
    bench.hear(DIAL_TONE).wait(1.2)
    assert bench.said() == [Dial("1")]


def test_at_sign_waits_for_five_seconds_of_silence_after_the_ringing(bench: ModemBench) -> None:
    bench.type("ATDT200@9\r").hear(DIAL_TONE).wait(2).hear(RINGING).wait(20)
    assert bench.said() == [Hook(True), Dial("200")]
    bench.hear(SILENCE).wait(4.9)
    assert bench.said() == []
    bench.wait(0.3)
    assert bench.said() == [Dial("9")]


def test_a_semicolon_returns_to_the_command_state(bench: ModemBench) -> None:
    bench.type("ATDT1;\r").hear(DIAL_TONE).wait(2)
    assert bench.heard() == "\r\nOK\r\n"
    assert bench.said() == [Hook(True), Dial("1")]
    bench.type("ATDT2\r").wait(1)
    assert bench.said() == [Dial("2")]  # the line was seized already
    bench.wait(50)
    assert bench.heard() == "\r\nNO CARRIER\r\n"


# ---- results of calls, by X


@pytest.mark.parametrize(("x", "expected"), [
    (0, "NO CARRIER"), (1, "NO CARRIER"), (2, "NO CARRIER"), (3, "BUSY"), (4, "BUSY")])  # fmt: skip
def test_x_decides_whether_busy_is_detected(bench: ModemBench, x: int, expected: str) -> None:
    bench.type(f"ATX{x}DT200\r").hear(DIAL_TONE).wait(3).hear(BUSY).wait(60)
    assert bench.heard() == f"\r\n{expected}\r\n"
    assert bench.said()[-1] == Hook(False)


@pytest.mark.parametrize(("x", "expected"), [
    (0, "NO CARRIER"), (1, "NO CARRIER"), (2, "NO DIALTONE"), (3, "NO CARRIER"), (4, "NO DIALTONE")])  # fmt: skip
def test_x_decides_whether_the_dial_tone_is_awaited(bench: ModemBench, x: int, expected: str) -> None:
    bench.type(f"ATX{x}DT200\r").wait(60)
    assert bench.heard() == f"\r\n{expected}\r\n"
    assert (Dial("200") in bench.said()) is (x in (0, 1, 3))


@pytest.mark.parametrize(("x", "expected"), [(0, "CONNECT"), *((x, "CONNECT 9600") for x in (1, 2, 3, 4))])
def test_x_decides_whether_connect_has_its_rate(bench: ModemBench, x: int, expected: str) -> None:
    bench.connected(command=f"ATX{x}DT200")
    assert bench.heard() == f"\r\n{expected}\r\n"


NUMBERS = [(300, 1), (1200, 5), (2400, 10), (4800, 11), (9600, 12), (14_400, 15), (28_800, 64), (33_600, 84)]


@pytest.mark.parametrize(("bps", "code"), NUMBERS)
def test_connect_has_the_number_of_its_rate(bench: ModemBench, bps: int, code: int) -> None:
    bench.connected(bps, command="ATV0DT200")
    assert bench.heard() == f"{code}\r"


RATES = [
    (0, ["CONNECT 38400"]),
    (1, ["CARRIER 9600", "PROTOCOL: LAP-M", "CONNECT 38400"]),
    (2, ["CONNECT 9600"]),
]


@pytest.mark.parametrize(("w", "expected"), RATES)
def test_w_decides_which_rate_connect_has(bench: ModemBench, w: int, expected: list[str]) -> None:
    bench.connected(command=f"ATW{w}DT200")
    assert bench.heard() == "".join(f"\r\n{line}\r\n" for line in expected)


@pytest.mark.manual("PD-271")
def test_s7_limits_the_wait_for_a_carrier(bench: ModemBench) -> None:
    bench.type("ATS7=10DT200\r").hear(DIAL_TONE).wait(1.57).hear(RINGING).wait(9.9)
    assert bench.line.sent == []
    bench.wait(0.2)
    assert bench.heard() == "\r\nNO CARRIER\r\n"
    assert bench.said()[-1] == Hook(False)


def test_an_at_sign_without_an_answer_gives_no_answer(bench: ModemBench) -> None:
    bench.type("ATDT200@\r").hear(DIAL_TONE).wait(2).hear(RINGING).wait(50)
    assert bench.heard() == "\r\nNO ANSWER\r\n"


@pytest.mark.parametrize("command", ["ATDT200\r", "ATA\r"])
def test_characters_of_the_first_125_ms_do_not_end_a_call(bench: ModemBench, command: str) -> None:
    """V.250, 6.3.1 and 6.3.5: a line feed may follow the command."""
    bench.type(command).hear(DIAL_TONE).wait(0.124)
    bench.line.take()
    bench.type("\n").wait(0.0005)
    assert bench.line.take() == []
    bench.wait(0.001).type("x")
    assert bench.heard() == "\r\nNO CARRIER\r\n"


def test_a_character_ends_a_call_that_is_being_made(bench: ModemBench) -> None:
    bench.type("ATDT200\r\n").hear(DIAL_TONE).wait(0.2)  # the line feed is ignored
    assert bench.line.sent == []
    bench.type("x")
    assert bench.heard() == "\r\nNO CARRIER\r\n"
    assert bench.said() == [Hook(True), Hook(False)]
    assert bench.ask("AT") == "\r\nOK\r\n"


# ---- answering


def test_ring_is_told_and_shown(bench: ModemBench) -> None:
    bench.hear(Ring(True, "100"))
    assert bench.heard() == "\r\nRING\r\n"
    assert bench.lines.ri
    assert bench.point("rings") == 1
    assert not bench.hear(Ring(False, "100")).inputs.ri
    bench.wait(9)
    assert bench.point("rings") == 0


@pytest.mark.manual("PD-246", "PD-248")
def test_s0_answers_after_the_ring_of_its_number(bench: ModemBench) -> None:
    bench.ask("ATS0=2")
    bench.hear(Ring(True), Ring(False)).wait(4)
    assert bench.said() == []
    bench.hear(Ring(True)).wait(1).hear(Ring(False))
    assert bench.said() == [Hook(True)]
    bench.wait(2)
    (offer,) = bench.said()
    assert isinstance(offer, Offer)


def test_ata_answers(bench: ModemBench) -> None:
    bench.hear(Ring(True), Ring(False))
    bench.heard()
    bench.type("ATA\r").wait(2)
    assert bench.said()[0] == Hook(True)
    bench.hear(Offer(everything(), 0)).wait(3).hear(Carrier(33_600))
    assert bench.said() == [Carrier(33_600)]
    assert bench.heard() == "\r\nCONNECT 33600\r\n"


def test_ata_without_a_caller_ends_after_s7(bench: ModemBench) -> None:
    bench.type("ATS7=5A\r").wait(5)
    assert bench.heard() == "\r\nNO CARRIER\r\n"


def test_an_offer_is_repeated_until_it_is_heard(bench: ModemBench) -> None:
    bench.type("ATA\r").wait(4.5)
    assert [type(message) for message in bench.said()] == [Hook, Offer, Offer, Offer]
    bench.hear(Offer(everything())).wait(2)
    assert bench.said() == []


# ---- handshake


def offered(bench: ModemBench, command: str) -> Offer:
    bench.type(command + "\r").wait(2.1)
    offer = bench.said()[-1]
    assert isinstance(offer, Offer)
    return offer


OFFERS = [
    ("ATA", {"V34", "V32B", "V32", "V22B", "V22", "V21"}, 33_600, 1),
    ("AT+MS=V32B;A", {"V32B", "V32", "V22B", "V22", "V21"}, 33_600, 1),
    ("AT+MS=V32B,0;A", {"V32B"}, 33_600, 1),
    ("AT+MS=,0;A", {"V34"}, 33_600, 1),
    ("ATN0+MS=V22;A", {"V22"}, 33_600, 1),
    ("AT+MS=,,300,9600;A", {"V34", "V32B", "V32", "V22B", "V22", "V21"}, 9600, 1),
    ("AT\\N0A", {"V34", "V32B", "V32", "V22B", "V22", "V21"}, 33_600, 0),
    ("AT\\N1A", {"V34", "V32B", "V32", "V22B", "V22", "V21"}, 33_600, 0),
    ("AT\\N2A", {"V34", "V32B", "V32", "V22B", "V22", "V21"}, 33_600, 2),
    ("AT\\N4A", {"V34", "V32B", "V32", "V22B", "V22", "V21"}, 33_600, 2),
    ("AT\\N5A", {"V34", "V32B", "V32", "V22B", "V22", "V21"}, 33_600, 1),
]


@pytest.mark.parametrize(("command", "names", "highest_bps", "correction"), OFFERS)
def test_settings_decide_what_is_offered(
    bench: ModemBench, command: str, names: set[str], highest_bps: int, correction: int
) -> None:
    offer = offered(bench, command)
    assert {modulation.name for modulation in offer.modulations} == names
    assert {modulation.highest_bps for modulation in offer.modulations} == {highest_bps}
    assert offer.correction == correction


AGREEMENTS = [
    (Offer(everything(), 1, 33_600), "CONNECT 33600"),
    (Offer(everything(), 1, 31_000), "CONNECT 28800"),  # a poor line
    (Offer((Modulation("V32B", 4800, 14_400),), 0), "CONNECT 14400"),
    (Offer((Modulation("V22", 1200, 1200), Modulation("V21", 300, 300)), 0), "CONNECT 1200"),
    (Offer((Modulation("V21", 300, 300),), 0), "CONNECT 300"),
    (Offer((Modulation("V34", 2400, 3000),), 0, 2000), "NO CARRIER"),
    (Offer((), 0), "NO CARRIER"),
]


@pytest.mark.parametrize(("theirs", "expected"), AGREEMENTS)
def test_modems_connect_at_the_best_that_both_and_the_line_have(
    bench: ModemBench, theirs: Offer, expected: str
) -> None:
    bench.dialled().hear(theirs).wait(3)
    carriers = [message for message in bench.said() if isinstance(message, Carrier)]
    if carriers:
        bench.hear(carriers[0])
    assert bench.heard() == f"\r\n{expected}\r\n"


@pytest.mark.manual("PD-272")
def test_modems_without_a_modulation_in_common_have_no_carrier(bench: ModemBench) -> None:
    bench.dialled("AT+MS=V34,0;DT200").hear(Offer((Modulation("V32B", 4800, 14_400),), 1)).wait(3)
    assert bench.heard() == "\r\nNO CARRIER\r\n"
    assert bench.said()[-1] == Hook(False)


@pytest.mark.parametrize("command", ["AT\\N2DT200", "AT\\N4DT200"])
def test_required_error_correction_ends_a_call_without_it(bench: ModemBench, command: str) -> None:
    bench.dialled(command).hear(Offer(everything(), 0)).wait(3)
    assert bench.heard() == "\r\nNO CARRIER\r\n"


def test_a_caller_that_gives_up_during_the_handshake_is_no_carrier(bench: ModemBench) -> None:
    bench.type("ATA\r").wait(3).hear(BUSY)
    assert bench.heard() == "\r\nNO CARRIER\r\n"


def test_a_called_modem_that_gives_up_during_the_handshake_is_no_carrier(bench: ModemBench) -> None:
    bench.dialled().hear(Offer(everything())).wait(1).hear(BUSY)
    assert bench.heard() == "\r\nNO CARRIER\r\n"


# ---- during a call


def test_s10_is_how_long_a_carrier_may_be_lost(bench: ModemBench) -> None:
    bench.connected()
    bench.heard()
    bench.hear(Carrier(0)).wait(1.3).hear(Carrier(9600)).wait(5)
    assert bench.line.sent == []
    bench.hear(Carrier(0)).wait(1.5)
    assert bench.heard() == "\r\nNO CARRIER\r\n"
    assert bench.said()[-1] == Hook(False)


def test_with_s10_at_its_end_a_lost_carrier_is_kept(bench: ModemBench) -> None:
    bench.connected(command="ATS10=255DT200").hear(Carrier(0)).wait(600)
    assert bench.point("call") == "connected"


@pytest.mark.manual("PD-275")
def test_the_other_end_that_hangs_up_ends_the_call(bench: ModemBench) -> None:
    bench.connected()
    bench.heard()
    assert bench.hear(BUSY).heard() == "\r\nNO CARRIER\r\n"
    assert bench.point("call") == "idle"


def test_an_exchange_that_has_started_again_ends_the_call(bench: ModemBench) -> None:
    bench.connected()
    bench.heard()
    assert bench.hear(DIAL_TONE).heard() == "\r\nNO CARRIER\r\n"


def test_s30_ends_a_call_without_data(bench: ModemBench) -> None:
    bench.connected(command="ATS30=2DT200").wait(15).hear(b"x").wait(19)
    bench.type("y").wait(19)
    bench.heard()
    bench.wait(1)
    assert bench.heard() == "\r\nNO CARRIER\r\n"


def test_the_escape_sequence_and_o(bench: ModemBench) -> None:
    bench.connected()
    bench.said()
    bench.heard()
    bench.wait(1).type("+++").wait(1)
    assert bench.heard() == "\r\nOK\r\n"
    assert bench.point("mode") == "online command"
    assert bench.said() == [b"+++", Ready(False)]
    assert bench.hear(b"held").ask("ATS7?") == "\r\n050\r\n\r\nOK\r\n"
    assert bench.ask("ATDT1") == "\r\nERROR\r\n"
    assert bench.ask("ATO") == "\r\nCONNECT 9600\r\nheld"
    assert bench.said() == [Ready(True)]
    bench.type("data").wait(0.1)
    assert bench.said() == [b"data"]


def test_h_ends_a_call_after_the_escape_sequence(bench: ModemBench) -> None:
    bench.connected().wait(1).type("+++").wait(1).heard()
    assert bench.ask("ATH") == "\r\nOK\r\n"
    assert bench.said()[-1] == Hook(False)
    assert not bench.inputs.dcd


def test_a_new_call_uses_no_data_of_the_last(bench: ModemBench) -> None:
    bench.connected().wait(1).type("+++").wait(1).hear(b"old").ask("ATH")
    bench.hear(SILENCE).connected()
    assert bench.heard() == "\r\nCONNECT 9600\r\n"
