"""The operation data of an MC-4 over the service channel."""

import re

import pytest
from mc4_bench import ENABLED, DriveBench

from fieldrig.errors import ConfigError, ControlError
from fieldrig_devices.mc4.idns import (
    BACKUP,
    COAST_OPTION,
    LANGUAGE,
    MC4_STATE,
    READ_PLATE,
    SIGNALS,
    STOP_TIME_LIMIT,
    idn_table,
)
from fieldrig_devices.sercos.idn import Attribute, Code, Element, Format, Length, ServiceError

# digest 3.1, line by line
DIGEST = """
0001 0002 0003 0004 0005 0087 0088 0090 0006 0007 0008 0089 0009 0010 0015 0016 0024 0185 0186 0187 0188
0011 0012 0013 0014 0028 0029 0095 0099 0129 0390 0017 0018 0019 0021 0022 0025 0192 0030 0140 0141 0142 0143
0169 0170 0032 0134 0135 0036 0040 0047 0051 0053 0080 0084 0189 0044 0076 0079 0086 0116
0091 0092 0109 0110 0111 0112 0113 0114 0100 0101 0104 0124 0127 0128 0206 0207 0380 0383 0384
"""


@pytest.fixture(scope="module")
def bench() -> DriveBench:
    return DriveBench({}).up()


def test_drive_has_the_data_of_the_digest(bench: DriveBench) -> None:
    data = bench.read(17)
    assert isinstance(data, bytes)
    there = {int.from_bytes(data[at : at + 2], "little") for at in range(0, len(data), 2)}
    assert {int(text) for text in re.findall(r"\d{4}", DIGEST)} <= there
    assert {0x8001, 0x8002, 0x8003, 0x8004} <= there


@pytest.mark.parametrize(
    ("idn", "attribute", "unit"),
    [
        (51, Attribute(Length.FOUR, Format.SIGNED, protected=(2, 3, 4)), "incr"),
        (40, Attribute(Length.FOUR, Format.SIGNED, 4, protected=(2, 3, 4)), "1/min"),
        (84, Attribute(Length.TWO, Format.SIGNED, 1, protected=(2, 3, 4)), "%"),
        (104, Attribute(Length.TWO, decimals=2), "(m/min)/mm"),
        (110, Attribute(Length.FOUR, decimals=3, protected=(2, 3, 4)), "A"),
        (383, Attribute(Length.TWO, Format.SIGNED, 1, protected=(2, 3, 4)), "degC"),
        (STOP_TIME_LIMIT, Attribute(Length.TWO), "ms"),
    ],
)
def test_attributes_and_units(bench: DriveBench, idn: int, attribute: Attribute, unit: str) -> None:
    word = bench.read(idn, Element.ATTRIBUTE)
    assert isinstance(word, bytes)
    assert Attribute.of(int.from_bytes(word, "little")) == attribute
    assert bench.read(idn, Element.UNIT) == unit.encode()


def test_every_datum_has_a_name_and_fits_its_limits() -> None:
    for datum in idn_table():
        assert datum.name
        numbers = [] if datum.attribute.length.is_list else [datum.number]
        for number in numbers:
            assert datum.minimum is None or datum.minimum <= number
            assert datum.maximum is None or number <= datum.maximum


def test_backup_list_can_be_written() -> None:
    table = idn_table()
    assert all(table[idn].attribute.protected != (2, 3, 4) for idn in BACKUP)


@pytest.mark.manual("PD-093")
def test_diagnosis_of_the_axis_over_the_ring() -> None:
    bench = DriveBench({}).up().enable()
    bench.rig.add_fault("d1", {"what": "overtemperature"})
    bench.run(300)
    assert (bench.number(390), bench.number(0x8000 | 32)) == (3117, 3117)
    assert bench.text(95) == "3117 motor temperature too high"
    bench.write(LANGUAGE, b"\x00\x00")
    assert bench.text(95) == "3117 Motortemperatur zu hoch"


def test_states_are_words_of_their_own_and_one_together(bench: DriveBench) -> None:
    assert (bench.number(MC4_STATE), bench.number(0x8000 | 2), bench.number(182)) == (0x10, 1, 0x0110)
    assert bench.number(SIGNALS) == 0b0101


def test_times_and_coast_options_are_the_controllers_to_write() -> None:
    bench = DriveBench({}).up().enable()
    assert bench.write(206, (40).to_bytes(2, "little")) == b""
    assert bench.write(207, (20).to_bytes(2, "little")) == b""
    assert bench.write(COAST_OPTION, b"\x01\x00") == b""
    bench.control = 0
    bench.run(100)
    assert bench.states() == (5, 0x02)  # bEnableCoast, standing: BrakeCouplingTime of 20 ms
    bench.control = ENABLED
    bench.run(60)
    assert bench.states() == (3, 0x21)


@pytest.mark.parametrize(
    ("idn", "data", "code"),
    [
        (104, b"\x00\x00", Code.BELOW_MINIMUM),
        (104, b"\xff\xff", Code.ABOVE_MAXIMUM),
        (51, bytes(4), Code.READ_ONLY),
        (32, b"\x0b\x00", Code.PROTECTED_NOW),
        (0x8FFF, b"", Code.NO_IDN),
        (47, bytes(4), 0x700A),  # it comes with every MDT
    ],
)
def test_what_it_refuses(bench: DriveBench, idn: int, data: bytes, code: int) -> None:
    refused = bench.write(idn, data)
    assert isinstance(refused, ServiceError)
    assert refused.code == code


def test_operation_mode_that_it_has_not_is_refused_when_it_is_written() -> None:
    datum = idn_table()[33]
    for mode in (0x0001, 0x0002, 0x0003, 0x000B):
        datum.write(mode.to_bytes(2, "little"), 2)
        assert datum.number == mode
    for mode, code in ((0, "7006"), (4, "7008"), (0x000A, "7008"), (0x000C, "7007")):
        with pytest.raises(ServiceError, match=code):
            datum.write(mode.to_bytes(2, "little"), 2)
    assert datum.number == 0x000B


@pytest.mark.long
def test_gain_that_was_written_counts() -> None:
    bench = DriveBench({"parameters": {"idns": {"S-0-0104": 120, "S-0-0032": 3}}}).up().enable()
    bench.follow(lambda cycle: 400 * cycle)
    bench.run(1_500)
    speed = 400 * 250  # increments a second
    assert bench.get("following_error") == pytest.approx(speed / (1.2 * 1000 / 60), rel=0.01)
    bench.write(104, (240).to_bytes(2, "little"))
    bench.run(1_500)
    assert bench.get("following_error") == pytest.approx(speed / (2.4 * 1000 / 60), rel=0.01)


def test_name_plate_can_be_read_again() -> None:
    bench = DriveBench({}).up()
    assert bench.command(READ_PLATE)
    bench.enable()
    assert not bench.command(READ_PLATE)


def test_class_2_change_bit_until_the_word_is_read() -> None:
    bench = DriveBench({}).up().enable()
    bench.rig.set("d1", "ambient", 78.0)  # the heat sink may have 80
    bench.run(200)
    assert bench.master.drives[1].status & 0x1000
    assert bench.number(12) == 0b010
    bench.run(8)
    assert not bench.master.drives[1].status & 0x1000


def test_class_3_says_what_it_does() -> None:
    bench = DriveBench({}).up().enable()
    assert bench.number(13) == 0b100_0011
    bench.follow(lambda cycle: 2_000 * cycle)
    bench.run(500)
    assert bench.number(13) & 0b10 == 0


def test_temperature_that_no_word_can_hold_is_the_most_that_it_can(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mc4_bench.FEEDBACK", (51, 182, 390, 383, 384))
    bench = DriveBench({}).up()
    bench.rig.set("d1", "ambient", 4_000.0)
    bench.run(40)
    assert bench.feedback()[3:] == (32_767, 32_767)
    with pytest.raises(ControlError, match="from -273 to 10000 degC"):
        bench.rig.set("d1", "ambient", 1e308)


def test_versions() -> None:
    bench = DriveBench({"versions": {"firmware": "00.15.02", "hardware": "02.00.00"}}).up()
    assert bench.text(30) == "MC-4/11/22/400 V00.15.02"
    assert (bench.text(0x8000 | 30), bench.text(0x8000 | 31)) == ("V00.15.02", "V02.00.00")


@pytest.mark.long
def test_mode_without_its_command_value_is_refused_before_operation() -> None:
    bench = DriveBench({"parameters": {"idns": {"S-0-0032": 6}}})
    bench.master.start()
    bench.master.request_phase(4)
    bench.run(3_000)
    assert bench.master.phase < 4


@pytest.mark.parametrize(
    ("idns", "mistake"),
    [
        ({"S-0-9999": 1}, "expected, for example, S-0-0047 or P-0-0010"),
        ({"S-0-0999": 1}, "S-0-0999 is not a parameter that can be set; expected one of S-0-0032, .*S-0-0406$"),
        ({"S-0-0017": 1}, "S-0-0017 is not a parameter"),
        ({"S-0-0051": 1}, "S-0-0051 is not a parameter"),
        ({"S-0-0099": 3}, "S-0-0099 is not a parameter"),
        ({"S-0-0206": 20}, "S-0-0206 is not a parameter"),
        ({"s-0-104": 0}, "s-0-104 cannot be 0; expected 1 to 6000"),
        ({"S-0-0104": 6_001}, "expected 1 to 6000"),
        ({"S-0-0091": -1}, "expected 0 to 2147483647"),
    ],
)
def test_parameters_of_a_rig_file_that_can_not_be_are_refused(idns: dict[str, int], mistake: str) -> None:
    with pytest.raises(ConfigError, match=mistake):
        DriveBench({"parameters": {"idns": idns}})


@pytest.mark.parametrize(
    ("fault", "mistake"),
    [
        ({"what": "overlod"}, r'faults\[0\].what: "overlod" doesn\'t fit\n +did you mean overload\?'),
        ({"what": "fire"}, r'what: "fire" doesn\'t fit\n +there are: dc_bus, enable_lost, .*wrong_motor'),
        ({"of": "motor"}, r"what: this key is missing\n +expected dc_bus or enable_lost or .*wrong_motor"),
        ({"what": "dc_bus", "sort": "x"}, r"sort: \"x\" doesn't fit\n +expected communication or undervoltage"),
    ],
)
def test_faults_of_a_rig_file_that_can_not_be_are_refused(fault: dict[str, str], mistake: str) -> None:
    with pytest.raises(ConfigError, match=mistake):
        DriveBench({"faults": [fault]})


def test_drive_says_what_may_be_in_its_telegrams(bench: DriveBench) -> None:
    def idns(number: int) -> list[int]:
        data = bench.read(number)
        assert isinstance(data, bytes)
        return [int.from_bytes(data[at : at + 2], "little") for at in range(0, len(data), 2)]

    assert {51, 53, 40, 84, 189, 11, 182, 390, 380, 383, 384} <= set(idns(187))
    assert idns(188) == [36, 47, 80]
    assert idns(19) == [32]
    assert {99, 127, 128, READ_PLATE} <= set(idns(25))


@pytest.mark.long
@pytest.mark.parametrize("mask", [0xFFFF, 0x0000])
def test_class_2_change_bit_is_masked(mask: int) -> None:
    bench = DriveBench({}).up()
    bench.write(97, mask.to_bytes(2, "little"))
    bench.rig.set("d1", "ambient", 78.0)
    bench.run(2_000)
    assert bench.number(12) == 0x0002
    bench.rig.set("d1", "ambient", 25.0)
    bench.run(2_000)
    assert bool(bench.master.drives[1].status & 0x1000) is bool(mask)


@pytest.mark.long
def test_class_3_tells_when_the_torque_is_at_its_limit() -> None:
    bench = DriveBench({}).up().enable()
    assert not bench.number(13) & 0x0010  # bit 3 is for S-0-0126, the torque threshold, which there is not
    bench.write(92, (10).to_bytes(2, "little"))  # 1 %
    bench.rig.set("d1", "load_torque", 0.5)
    bench.run(40)
    assert bench.number(13) & 0x0018 == 0x0010


def test_command_values_of_the_mdt_can_be_read_over_the_service_channel() -> None:
    bench = DriveBench({}).up().enable()
    bench.raw = (ENABLED | 0x0100, 1_234_567, 600_000, -50)
    bench.run(40)
    assert (bench.number(47), bench.number(36), bench.number(80)) == (1_234_567, 600_000, 0x10000 - 50)


@pytest.mark.long
def test_reset_clears_the_failures_of_the_interface() -> None:
    bench = DriveBench({}).up()
    bench.rig.add_fault("ring", {"what": "distort", "station": "d1", "telegram": "mdt", "count": 2})
    bench.run(100)
    bench.master.request_phase(4)
    bench.run(3_000)
    assert bench.number(14) == 0x0014
    assert bench.code() == 2112
    assert bench.command(99)
    assert (bench.number(14), bench.code()) == (0x0004, 0)
