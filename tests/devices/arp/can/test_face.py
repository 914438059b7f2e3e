"""Reads and writes of the card by SDO, from a master.  Node 10; requests and answers as in CiA 301 7.2.4.3."""

import pytest
from arp_face import FaceBench

from fieldrig_devices.arp.card_access import CardState

INVALID_VALUE, TOO_HIGH, TOO_LOW = "30 00 09 06", "31 00 09 06", "32 00 09 06"
READ_ONLY, DEVICE_STATE = "02 00 01 06", "22 00 00 08"


@pytest.fixture
def bench() -> FaceBench:
    bench = FaceBench()
    assert bench.start() == ["70A#00"]
    return bench


@pytest.mark.long
@pytest.mark.manual("ARP-010")
@pytest.mark.parametrize(("node_id", "boot_up"), [(1, "701#00"), (10, "70A#00"), (127, "77F#00")])
def test_node_id_is_parameter_5(node_id: int, boot_up: str) -> None:
    bench = FaceBench()
    bench.card.parameters.ram[0][5] = node_id * 1000
    assert bench.start() == [boot_up]


@pytest.mark.long
@pytest.mark.manual("ARP-010")
def test_node_id_is_taken_at_the_start_only(bench: FaceBench) -> None:
    assert bench.card.set_parameter(0, 5, 11_000)
    bench.refresh()
    assert bench.send("000#82 0A") == ["70A#00"]  # reset communication


def test_identity(bench: FaceBench) -> None:
    assert bench.sdo("40 18 10 02 00 00 00 00") == "43 18 10 02 29 0a 00 00"  # product code
    assert bench.sdo("40 18 10 04 00 00 00 00") == "43 18 10 04 07 00 00 00"  # serial number: nn
    assert bench.sdo("40 08 10 00 00 00 00 00") == "47 08 10 00 41 52 50 00"  # ARP


@pytest.mark.parametrize(
    ("variable", "request_", "answer"),
    [
        (1, "40 00 20 01", "43 00 20 01"),
        (250, "40 00 20 FA", "43 00 20 fa"),
        (251, "40 01 20 01", "43 01 20 01"),
        (1000, "40 03 20 FA", "43 03 20 fa"),
    ],
)
def test_variables_are_read_raw(bench: FaceBench, variable: int, request_: str, answer: str) -> None:
    bench.card.V[variable] = -1500
    assert bench.sdo(f"{request_} 00 00 00 00") == f"{answer} 24 fa ff ff"


def test_a_variable_is_written_at_once_and_holds_any_32_bits(bench: FaceBench) -> None:
    assert bench.sdo("23 03 20 FA 88 13 00 00") == "60 03 20 fa 00 00 00 00"
    assert bench.card.V[1000] == 5000
    assert bench.sdo("23 00 20 01 00 00 00 80") == "60 00 20 01 00 00 00 00"
    assert bench.card.V[1] == -(1 << 31)


@pytest.mark.long
def test_there_is_no_v1001(bench: FaceBench) -> None:
    assert bench.sdo("40 03 20 FB 00 00 00 00") == "80 03 20 fb 11 00 09 06"


def test_flags_are_words_with_the_first_flag_in_bit_0(bench: FaceBench) -> None:
    bench.card.F[33] = bench.card.F[64] = 1
    assert bench.sdo("40 10 20 02 00 00 00 00") == "43 10 20 02 01 00 00 80"
    assert bench.sdo("23 10 20 02 02 00 00 00") == "60 10 20 02 00 00 00 00"
    assert (bench.card.F[33], bench.card.F[34], bench.card.F[64]) == (0, 1, 0)


def test_read_only_bits_of_flag_words_are_dropped(bench: FaceBench) -> None:
    """F257 to F261 belong to the system; F262 stops the axis."""
    bench.card.F[260] = 1
    assert bench.sdo("23 10 20 09 FF FF FF FF") == "60 10 20 09 00 00 00 00"
    assert bench.card.F[257:264] == [0, 0, 0, 1, 0, 1, 0]
    assert bench.sdo("23 10 20 09 00 00 00 00") == "60 10 20 09 00 00 00 00"
    assert bench.card.F[257:264] == [0, 0, 0, 1, 0, 0, 0]


@pytest.mark.long
def test_outputs_are_written_unless_they_are_held(bench: FaceBench) -> None:
    assert bench.sdo("23 11 20 01 05 00 00 00") == "60 11 20 01 00 00 00 00"
    assert bench.card.O[101:105] == [1, 0, 1, 0]
    bench.card.is_willing = False
    assert bench.sdo("23 11 20 01 00 00 00 00") == f"80 11 20 01 {DEVICE_STATE}"
    assert bench.card.O[101:105] == [1, 0, 1, 0]


def test_inputs_are_read_only(bench: FaceBench) -> None:
    bench.card.I[302] = 1
    assert bench.sdo("40 12 20 03 00 00 00 00") == "43 12 20 03 02 00 00 00"
    assert bench.sdo("23 12 20 03 00 00 00 00") == f"80 12 20 03 {READ_ONLY}"


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("40 00 22 01", "43 00 22 01 dc 05 00 00"),  # position of axis 1
        ("40 01 22 02", "43 01 22 02 24 fa ff ff"),  # speed of axis 2
        ("40 02 22 01", "43 02 22 01 07 00 00 00"),  # tracking error
        ("40 03 22 02", "43 03 22 02 08 00 00 00"),  # F292: arrived
        ("40 20 20 06", "43 20 20 06 10 27 00 00"),  # ADC 6: 10.000 V
        ("40 21 20 02", "43 21 20 02 f0 d8 ff ff"),  # DAC 2: -10.000 V
    ],
)
def test_axes_and_analog_signals(bench: FaceBench, request_: str, answer: str) -> None:
    card = bench.card
    card.positions[1], card.speeds[2], card.tracking_errors[1], card.F[292] = 1500, -1500, 7, 1
    card.adc[6], card.dac[2] = 10_000, -10_000
    assert bench.sdo(f"{request_} 00 00 00 00") == answer


def test_a_speed_beyond_32_bits_reads_as_the_limit(bench: FaceBench) -> None:
    bench.card.speeds[1] = 3_000_000_000
    assert bench.sdo("40 01 22 01 00 00 00 00") == "43 01 22 01 ff ff ff 7f"


@pytest.mark.long
def test_state_error_warning_program(bench: FaceBench) -> None:
    card = bench.card
    card.state = CardState.BLOCKED
    card.errors.fail(116, 2)
    card.errors.warn(203)
    assert bench.sdo("40 02 21 00 00 00 00 00") == "4f 02 21 00 05 00 00 00"
    assert bench.sdo("40 03 21 00 00 00 00 00") == "4b 03 21 00 74 00 00 00"
    assert bench.sdo("40 04 21 00 00 00 00 00") == "4b 04 21 00 cb 00 00 00"
    assert bench.sdo("40 05 21 00 00 00 00 00") == "4f 05 21 00 02 00 00 00"
    assert bench.sdo("40 07 21 00 00 00 00 00") == "4f 07 21 00 07 00 00 00"
    assert bench.sdo("40 06 21 00 00 00 00 00") == "41 06 21 00 06 00 00 00"  # 6 bytes follow
    assert bench.sdo("60 00 00 00 00 00 00 00") == "03 57 49 4e 44 45 52 00"  # WINDER


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("23 00 23 01 E8 03 00 00", "60 00 23 01 00 00 00 00"),  # @Par[1] = 1 ms
        ("23 00 23 01 00 00 00 00", f"80 00 23 01 {TOO_LOW}"),
        ("23 00 23 01 F8 2A 00 00", f"80 00 23 01 {TOO_HIGH}"),  # 11 ms
        ("23 00 23 01 DC 05 00 00", f"80 00 23 01 {INVALID_VALUE}"),  # 1.5 ms
        ("23 00 23 06 88 13 00 00", f"80 00 23 06 {TOO_LOW}"),  # 5 kbaud
        ("23 00 23 06 40 0D 03 00", f"80 00 23 06 {INVALID_VALUE}"),  # 200 kbaud
        ("23 01 23 04 A0 0F 00 00", f"80 01 23 04 {TOO_HIGH}"),  # kind 4
        ("23 02 23 15 F0 D8 FF FF", "60 02 23 15 00 00 00 00"),  # @Par2[21] = -10.000
        ("23 02 23 15 EF D8 FF FF", f"80 02 23 15 {TOO_LOW}"),
        ("23 02 23 1A 00 00 00 00", "80 02 23 1a 11 00 09 06"),  # there is no @Par2[26]
    ],
)
def test_parameters_have_their_limits(bench: FaceBench, request_: str, answer: str) -> None:
    assert bench.sdo(request_) == answer


def test_parameters_are_the_copies_in_ram(bench: FaceBench) -> None:
    bench.card.parameters.ram[1][11] = 2500
    assert bench.sdo("40 01 23 0B 00 00 00 00") == "43 01 23 0b c4 09 00 00"
    bench.sdo("23 01 23 0B E8 03 00 00")
    assert bench.card.parameters.ram[1][11] == 1000
    assert bench.card.asked == []


def test_words_of_the_wrong_size_are_refused(bench: FaceBench) -> None:
    assert bench.sdo("2B 00 20 01 00 00 00 00") == "80 00 20 01 13 00 07 06"
    assert bench.sdo("23 00 21 00 01 00 00 00") == "80 00 21 00 12 00 07 06"
