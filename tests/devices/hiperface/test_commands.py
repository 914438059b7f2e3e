"""Every command of the parameter channel, byte by byte.

Telegrams of 42h, 50h, 52h and 53h as in the wiki of Nilab; lengths and meanings as `hiperface.telegram` says.
"""

import pytest
from hiperface_bench import PLATE_BYTES, EncoderBench, crc16, telegram

from fieldrig_devices.hiperface.shaft import Turning


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("40 42 02", "40 42 00 00 a0 00 a2"),
        ("40 50 10", "40 50 00 10"),
        ("40 52 12", "40 52 e4 27 80 00 51"),
        ("40 46 06", "40 46 00 00 00 06"),
    ],
)
@pytest.mark.manual("PD-008")
def test_telegrams_are_the_published_ones(request_: str, answer: str) -> None:
    bench = EncoderBench(turns=1.25)
    bench.send(bytes.fromhex(request_))
    assert bench.heard() == bytes.fromhex(answer)


def test_reset_has_no_answer_and_is_followed_by_deafness() -> None:
    bench = EncoderBench()
    bench.send(bytes.fromhex("40 53 13"))
    assert bench.heard(50) == b""
    bench.send(bytes.fromhex("40 42 02"))
    assert bench.heard(60) == b""
    assert bench.ask("42") == "42 00 00 00 00"


@pytest.mark.manual("PD-173", "PD-174")
@pytest.mark.parametrize(
    ("kind", "turns", "position"),
    [
        ("single_turn", 0.0, 0),
        ("single_turn", 0.5, 16384),
        ("single_turn", 7.25, 8192),
        ("single_turn", -0.25, 24576),
        ("multi_turn", 7.25, 7 * 32768 + 8192),
        ("multi_turn", 4095.999999, 4096 * 32768 - 1),
        ("multi_turn", 4096.0, 0),
        ("multi_turn", -1 / 32768, 4096 * 32768 - 1),
    ],
)
def test_position_is_15_bits_in_a_turn_and_4096_turns(kind: str, turns: float, position: int) -> None:
    bench = EncoderBench("multi_turn" if kind == "multi_turn" else "single_turn", turns)
    assert bench.ask("42") == "42 " + position.to_bytes(4, "big").hex(" ")


def test_type_code_tells_single_from_multi_turn() -> None:
    assert EncoderBench("single_turn").ask("52") == "52 e4 22 80 00"
    assert EncoderBench("multi_turn").ask("52") == "52 e4 27 80 00"


def test_there_is_no_position_at_a_speed_that_is_too_high() -> None:
    bench = EncoderBench()
    bench.turning = Turning(3.0, 99.0)
    assert bench.ask("42") == "42 00 01 80 00"
    bench.turning = Turning(3.0, -101.0)
    assert bench.ask("42") == "50 1f"


def test_position_can_be_set_and_is_kept() -> None:
    bench = EncoderBench(turns=2.5)
    assert bench.ask("43 00 00 10 00 55") == "43"
    assert bench.ask("42") == "42 00 00 10 00"
    assert len(bench.kept) == 1
    bench.turning = Turning(2.75)
    assert bench.ask("42") == "42 00 00 30 00"
    assert bench.ask("43 00 00 10 00 56") == "50 0f"
    assert bench.ask("43 08 00 00 00 55") == "50 0d"  # beyond 4096 turns


@pytest.mark.manual("PD-175")
@pytest.mark.parametrize(
    ("period", "sine", "cosine"),
    [(0.0, "00 00", "40 00"), (0.25, "40 00", "00 00"), (0.5, "00 00", "c0 00"), (0.75, "c0 00", "00 00")],
)
def test_signals_are_a_quarter_of_a_period_apart(period: float, sine: str, cosine: str) -> None:
    bench = EncoderBench(turns=(5 + period) / 1024)
    assert bench.ask("44 00") == f"44 00 {sine}"
    assert bench.ask("44 01") == f"44 01 {cosine}"


def test_temperature_is_read_in_degrees_celsius() -> None:
    bench = EncoderBench()
    assert bench.ask("44 48") == "44 48 00 19"
    bench.encoder.requests.set_temperature(-7.4)
    assert bench.ask("44 48") == "44 48 ff f9"
    assert bench.ask("44 49") == "50 0d"


def test_counter_goes_up_and_is_cleared_with_code_0() -> None:
    bench = EncoderBench()
    for _ in range(3):
        assert bench.ask("47") == "47"
    assert bench.ask("46") == "46 00 00 03"
    assert bench.ask("49 54") == "50 0f"
    assert bench.ask("46") == "46 00 00 03"
    assert bench.ask("49 55") == "49"
    assert bench.ask("46") == "46 00 00 00"
    assert len(bench.kept) == 4


def test_counter_has_24_bits() -> None:
    bench = EncoderBench()
    bench.encoder.eeprom.counter = 0xFFFFFF
    assert bench.ask("46") == "46 ff ff ff"
    kept = len(bench.kept)
    assert bench.ask("47") == "50 08"  # counter overflow; it stays where it is
    assert bench.ask("46") == "46 ff ff ff"
    assert len(bench.kept) == kept
    assert bench.ask("49 55") == "49"
    assert bench.ask("47") == "47"
    assert bench.ask("46") == "46 00 00 01"


@pytest.mark.manual("PD-170")
def test_plate_stands_in_data_field_0() -> None:
    bench = EncoderBench()
    whole = PLATE_BYTES + crc16(PLATE_BYTES)
    assert bench.ask("4c 00") == "4c 00 cf"
    assert bench.ask("4a 00 00 06 55") == "4a 00 00 06 46 52 4e 50 01 64"
    assert bytes.fromhex(bench.ask("4a 00 00 80 55"))[4:] == whole + b"\xff" * 28
    assert bench.ask("4a 00 06 03 55") == "4a 00 06 03 53 4d 2d"


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        ("4a 00 00 06 56", "0f"),  # wrong code
        ("4a 01 00 06 55", "12"),  # no such field
        ("4a 00 7f 02 55", "11"),  # beyond its end
        ("4a ff 00 0a 55", "12"),  # the extended type label, which SRS and SRM haven't got
        ("4b 00 80 01 55 aa", "11"),
        ("4b 00 00 01 aa 00", "0f"),
        ("4b 01 00 01 55 00", "12"),
        ("4c 01", "12"),
        ("4d 02 c8 55", "12"),  # fields are created in order
        ("4d 01 48 55", "12"),  # one that isn't there cannot be deleted
        ("4f 04 55 66", "0d"),
        ("4f 00 56 66", "0f"),
        ("55 60 55", "0d"),
        ("55 41 aa", "0f"),
        ("57 e7 55", "0d"),  # there is no such rate
        ("57 ec 55", "0d"),
        ("57 e5 00", "0f"),
        ("99", "0b"),
        ("45", "0b"),
    ],
)
def test_refusals_are_the_status_telegram(request_: str, status: str) -> None:
    bench = EncoderBench()
    assert bench.ask(request_) == f"50 {status}"
    assert bench.kept == []
    assert bench.ask("50") == "50 00"  # it has been reported


def test_data_are_stored_and_kept_before_the_answer() -> None:
    bench = EncoderBench()
    bench.send(telegram("4b 00 70 04 55 01 02 03 04"))
    assert len(bench.kept) == 1
    assert bench.heard() == telegram("4b 00 70 04")
    assert bench.ask("4a 00 6f 06 55") == "4a 00 6f 06 ff 01 02 03 04 ff"


def test_data_fields_are_created_changed_and_deleted() -> None:
    bench = EncoderBench()
    assert bench.ask("4e") == "4e 06 80 01"  # 1792 - 128
    assert bench.ask("4d 01 c1 00") == "4d 01 c1"  # 32 bytes, no code
    assert bench.ask("4e") == "4e 06 60 02"
    assert bench.ask("4a 01 1e 02 00") == "4a 01 1e 02 ff ff"
    assert bench.ask("4b 01 1f 01 00 aa") == "4b 01 1f 01"
    assert bench.ask("4d 01 81 00") == "4d 01 81"  # write protected
    assert bench.ask("4b 01 1f 01 00 bb") == "50 0e"
    assert bench.ask("4d 01 f8 55") == "4d 01 f8"  # 16 bytes, code 3
    assert bench.ask("4a 01 00 01 54") == "50 0f"
    assert bench.ask("4d 00 ce 55") == "50 10"  # not the last one
    assert bench.ask("4d 00 4f 55") == "50 10"
    assert bench.ask("4d 01 48 55") == "50 0d"  # not its status
    assert bench.ask("4d 01 78 55") == "4d 01 78"
    assert bench.ask("4e") == "4e 06 80 01"


def test_memory_comes_to_its_end() -> None:
    bench = EncoderBench()
    for number in range(1, 14):
        assert bench.ask(f"4d {number:02x} c7 55") == f"4d {number:02x} c7"
    assert bench.ask("4e") == "4e 00 00 0e"
    assert bench.ask("4d 0e c0 55") == "50 0d"


def test_access_codes_are_changed_one_by_one() -> None:
    bench = EncoderBench()
    assert bench.ask("4f 00 55 66") == "4f 00"
    assert bench.ask("4a 00 00 01 55") == "50 0f"
    assert bench.ask("4a 00 00 01 66") == "4a 00 00 01 46"
    assert bench.ask("4d 01 d8 55") == "4d 01 d8"  # code 1 is what it was
    assert bench.ask("49 55") == "50 0f"
    assert bench.ask("49 66") == "49"


@pytest.mark.parametrize(
    ("request_", "answer"), [("43 00 00 10 00", "43"), ("49", "49"), ("55 41", "55 41"), ("57 65", "57 65")]
)
def test_settings_of_the_encoder_need_access_code_0_and_no_other(request_: str, answer: str) -> None:
    bench = EncoderBench()
    bench.ask("4f 00 55 66")
    assert bench.ask(f"{request_} 55") == "50 0f"
    bench.send(telegram(f"{request_} 66"))
    assert bench.heard() in (telegram(answer), telegram(answer, 0x41))


def test_address_is_allocated_at_once() -> None:
    bench = EncoderBench()
    bench.send(telegram("55 41 55"))
    assert bench.heard() == telegram("55 41", 0x41)
    bench.wait(10)
    bench.send(telegram("42"))
    assert bench.heard() == b""
    bench.send(telegram("42", 0x41))
    assert bench.heard() == telegram("42 00 00 00 00", 0x41)
    bench.wait(10)
    bench.send(telegram("42", 0xFF))  # broadcast
    assert bench.heard() == telegram("42 00 00 00 00", 0x41)


def test_serial_number_and_version_are_told() -> None:
    assert bytes.fromhex(EncoderBench().ask("56"))[1:] == b"FR0000001fieldrig 1          "


def test_line_is_configured_for_the_next_reset() -> None:
    bench = EncoderBench()
    assert bench.ask("57 65 55") == "57 65"
    assert bench.encoder.form.baud == 9600
    assert bench.ask("52") == "52 65 27 80 00"
    bench.ask("53")
    assert (bench.encoder.form.baud, bench.encoder.form.parity) == (19200, "E")


def test_messages_wait_are_flagged_and_read_one_by_one() -> None:
    bench = EncoderBench()
    bench.encoder.requests.set_temperature(116)
    assert bench.ask("42") == "c2 00 00 00 00"
    assert bench.ask("99") == "d0 0b"  # a refusal is reported at once; stored messages keep waiting
    assert bench.ask("50") == "50 1e"
    assert bench.ask("50") == "50 00"
    assert bench.ask("42") == "42 00 00 00 00"


def test_too_hot_is_told_when_it_becomes_so_and_not_again_and_again() -> None:
    bench = EncoderBench()
    for degc in (116, 117, 130):
        bench.encoder.requests.set_temperature(degc)
    assert [bench.ask("50") for _ in range(2)] == ["50 1e", "50 00"]
    bench.encoder.requests.set_temperature(131)
    assert bench.ask("50") == "50 00"
    bench.encoder.requests.set_temperature(115)
    bench.encoder.requests.set_temperature(116)
    assert bench.ask("50") == "50 1e"
