"""The name plate: its words, its bytes, what is refused."""

from pathlib import Path
from typing import Any

import pytest
from hiperface_bench import PLATE, PLATE_BYTES, crc16
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.errors import ConfigError
from fieldrig_devices.hiperface.drive_end import motor_data
from fieldrig_devices.hiperface.plate import LENGTH, NamePlate, PlateError, Wrong
from fieldrig_devices.hiperface.plate_file import as_yaml, edited, load_plate, save_plate

WHOLE = (PLATE_BYTES + crc16(PLATE_BYTES)).ljust(128, b"\xff")
SAMPLES = sorted((Path(__file__).parents[3] / "configs" / "plates").glob("*.yaml"))


@pytest.mark.manual("PD-177")
def test_plate_is_these_bytes() -> None:
    assert PLATE.encode() == WHOLE
    assert NamePlate.decode(WHOLE) == PLATE
    assert NamePlate.decode(WHOLE[:100]) == PLATE


@pytest.mark.manual("PD-177")
def test_acceleration_time_is_to_rated_speed_at_peak_torque() -> None:
    # 4.2e-4 kg m2 * 314.16 rad/s / 32 Nm
    assert PLATE.acceleration_time_ms == pytest.approx(4.1233, abs=1e-4)


@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        ({"rated_speed_rpm": 6000}, "above max_speed_rpm"),
        ({"rated_torque_nm": 9.0}, "above standstill_torque_nm"),
        ({"peak_torque_nm": 7.0}, "above peak_torque_nm"),
        ({"rated_current_a": 5.5}, "above standstill_current_a"),
        ({"peak_current_a": 4.0}, "above peak_current_a"),
        ({"winding_warning_c": 150.0}, "above winding_limit_c"),
        ({"torque_constant_nm_per_a": 1.9}, "1.6 Nm/A"),
        ({"rated_current_a": 3.945}, "not a multiple of 0.01"),
        ({"inertia_kgcm2": 0.0}, "greater than 0"),
        ({"pole_pairs": 256}, "less than or equal to 255"),
        ({"type": "Motör"}, "pattern"),
        ({"type": " SM"}, "pattern"),
        ({"type": "S" * 25}, "at most 24"),
        ({"serial_number": ""}, "at least 1"),
        ({"winding_limit_c": float("nan")}, "less than or equal"),
        ({"rated_speed_rpm": "3000"}, "valid integer"),
        ({"colour": "red"}, "not permitted"),
    ],
)
def test_plates_that_can_not_be_are_refused(change: dict[str, Any], wrong: str) -> None:
    with pytest.raises(ValidationError, match=wrong):
        NamePlate.model_validate(PLATE.model_dump() | change)


@pytest.mark.parametrize(
    ("data", "wrong"),
    [
        (b"", Wrong.BLANK),
        (b"\xff" * 128, Wrong.BLANK),
        (b"\x00" * 128, Wrong.BLANK),
        (b"KEB1" + WHOLE[4:], Wrong.FOREIGN),
        (b"FRNP\x02" + WHOLE[5:], Wrong.FOREIGN),
        (b"FRN", Wrong.FOREIGN),
        (WHOLE[:99], Wrong.CHECKSUM),
        (WHOLE[:98] + b"\x00\x00", Wrong.CHECKSUM),
        (b"FRNP\x01\x20" + WHOLE[6:], Wrong.CHECKSUM),
    ],
)
def test_bytes_that_are_no_plate(data: bytes, wrong: Wrong) -> None:
    with pytest.raises(PlateError) as caught:
        NamePlate.decode(data)
    assert caught.value.wrong is wrong


def test_right_bytes_of_a_plate_that_can_not_be() -> None:
    body = PLATE_BYTES[:74] + b"\x00" + PLATE_BYTES[75:]  # no pole pairs
    with pytest.raises(PlateError, match="pole_pairs") as caught:
        NamePlate.decode(body + crc16(body))
    assert caught.value.wrong is Wrong.VALUES


@settings(max_examples=100, deadline=None)
@given(st.integers(0, LENGTH * 8 - 1))
def test_no_single_bit_may_be_wrong(bit: int) -> None:
    data = bytearray(WHOLE)
    data[bit // 8] ^= 1 << bit % 8
    with pytest.raises(PlateError):
        NamePlate.decode(bytes(data))


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=130))
def test_garbage_is_no_plate(data: bytes) -> None:
    with pytest.raises(PlateError):
        NamePlate.decode(data)


@st.composite
def plates(draw: st.DrawFn) -> NamePlate:
    def rising(most: int, scale: int) -> list[float]:
        return [raw / scale for raw in sorted(draw(st.lists(st.integers(1, most), min_size=3, max_size=3)))]

    torques, currents = rising(60_000_000, 1000), rising(65535, 100)
    constant = round(torques[1] / currents[1] * 1000) / 1000
    speeds = sorted(draw(st.lists(st.integers(1, 65535), min_size=2, max_size=2)))
    texts = st.from_regex(r"[!-~]([ -~]{0,10}[!-~])?", fullmatch=True)
    values = {
        "type": draw(texts),
        "serial_number": draw(texts),
        "rated_speed_rpm": speeds[0],
        "max_speed_rpm": speeds[1],
        "rated_torque_nm": torques[0],
        "standstill_torque_nm": torques[1],
        "peak_torque_nm": torques[2],
        "rated_current_a": currents[0],
        "standstill_current_a": currents[1],
        "peak_current_a": currents[2],
        "torque_constant_nm_per_a": constant,
        "inertia_kgcm2": draw(st.integers(1, 0xFFFF_FFFF)) / 1000,
        "pole_pairs": draw(st.integers(1, 255)),
        "is_multi_turn": draw(st.booleans()),
        "offset_increments": draw(st.integers(-1_000_000, 1_000_000)),
    }
    try:
        return NamePlate.model_validate(values)
    except ValidationError:
        return PLATE  # no torque constant that fits


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(plates())
def test_what_is_read_is_what_was_written(plate: NamePlate) -> None:
    assert NamePlate.decode(plate.encode()) == plate


@pytest.mark.long
@settings(max_examples=20, deadline=None)
@given(plate=plates())
def test_file_holds_the_plate(plate: NamePlate, tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.mktemp("plate") / "motor.yaml"
    save_plate(plate, file)
    assert load_plate(file) == plate


@pytest.mark.parametrize("file", SAMPLES, ids=lambda file: file.stem)
@pytest.mark.manual("PD-008")
def test_samples_are_right(file: Path) -> None:
    plate = load_plate(file)
    assert NamePlate.decode(plate.encode()) == plate
    assert plate.peak_torque_nm == pytest.approx(4 * plate.standstill_torque_nm)  # 4-fold overload
    data = motor_data(plate)
    assert (data.type, data.pole_pairs) == (plate.type, plate.pole_pairs)
    assert data.standstill_current_a == pytest.approx(plate.standstill_current_a, rel=0.05)


def test_mistakes_in_a_file_are_named_with_their_lines(tmp_path: Path) -> None:
    file = tmp_path / "motor.yaml"
    file.write_text(as_yaml(PLATE).replace("pole_pairs: 4", "pole_pears: 4"))
    with pytest.raises(ConfigError) as caught:
        load_plate(file)
    assert f"{file}:14: pole_pears: there is no such key" in str(caught.value)
    assert "pole_pairs: this key is missing" in str(caught.value)


@pytest.mark.parametrize("text", ["", "- 1\n", "just words\n", "type: [\n"])
def test_what_is_no_plate_file(text: str, tmp_path: Path) -> None:
    file = tmp_path / "motor.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError):
        load_plate(file)
    with pytest.raises(ConfigError, match="cannot be read"):
        load_plate(tmp_path / "other.yaml")


def test_edited_values_are_as_in_a_file() -> None:
    changed = edited(PLATE, {"rated_current_a": "4.2", "serial_number": "17", "is_multi_turn": "false"})
    assert (changed.rated_current_a, changed.serial_number, changed.is_multi_turn) == (4.2, "17", False)
    for change in ({"rated_current_a": "much"}, {"no_such_key": "1"}, {"pole_pairs": "4.5"}, {"is_multi_turn": "1"}):
        with pytest.raises(ConfigError):
            edited(PLATE, change)
