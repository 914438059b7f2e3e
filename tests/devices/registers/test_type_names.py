"""Messages about a wrong type of a register, and about a start value that does not fit."""

from pathlib import Path

import pytest

from fieldrig.errors import ConfigError
from fieldrig_devices.registers.table import load_table
from fieldrig_devices.registers.type_names import OTHER_NAMES, meant


def refused(folder: Path, entry: str) -> str:
    file = folder / "table.yaml"
    file.write_text(f"input_registers: [{{address: 0, name: a, {entry}}}]\n")
    with pytest.raises(ConfigError) as wrong:
        load_table(file)
    return str(wrong.value).partition(": ")[2]


@pytest.mark.parametrize(
    ("written", "wanted"),
    [
        ("float", "f32"),
        ("FLOAT32", "f32"),
        ("REAL", "f32"),
        ("double", "f64"),
        ("uint16", "u16"),
        ("uint16_t", "u16"),
        ("WORD", "u16"),
        ("INT", "s16"),
        ("i32", "s32"),
        ("DINT", "s32"),
        ("lreal", "f64"),
        ("byte", "u16"),  # a register has 16 bits
        ("boolean", "bool"),
        ("string", "string[n]"),
    ],
)
def test_the_type_that_is_meant_is_named(tmp_path: Path, written: str, wanted: str) -> None:
    assert f"{written!r} is no type here; did you mean {wanted}?" in refused(tmp_path, f"type: {written}")


def test_no_other_name_is_a_type_itself() -> None:
    assert all(meant(other) == name for name, others in OTHER_NAMES.items() for other in others)
    assert meant("U16") == "u16"
    assert meant("colour") is None


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (
            "type: u16, scale: 0.1, initial: 7000",
            "initial: 7000 is 70000 in the register, by scale 0.1; expected 0 to 6553.5, for u16, in the unit",
        ),
        (
            "type: s16, scale: 0.1, offset: -40, initial: 4000",
            "initial: 4000 is 40400 in the register, by scale 0.1 and offset -40; expected -3316.8 to 3236.7, for s16",
        ),
        ("type: u16, initial: 70000", "initial: expected 0 to 65535, for u16, got 70000"),
        ("type: u16, scale: -1, initial: 1", "initial: 1 is -1 in the register, by scale -1; expected -65535 to 0"),
    ],
)
def test_a_start_value_that_does_not_fit_says_what_the_scale_does_to_it(tmp_path: Path, entry: str, said: str) -> None:
    assert said in refused(tmp_path, entry)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (
            "type: u16, scale: 10, initial: 5",
            "5 is 0.5 in the register, by scale 10, which is rounded to 0; expected 0, or",
        ),
        ("type: s32, scale: 0.1, initial: -0.04", "-0.04 is -0.4 in the register, by scale 0.1, which is rounded to 0"),
        ("type: u16, initial: 0.3", "0.3 is 0.3 in the register, by scale 1, which is rounded to 0; expected 0, or at"),
        (
            "type: u16, scale: 5, offset: 100, initial: 102",
            "102 is 0.4 in the register, by scale 5 and offset 100, which is rounded to 0; expected 100, or at least 5",
        ),
        ("type: bcd16, scale: 100, initial: 20", "20 is 0.2 in the register, by scale 100, which is rounded to 0"),
    ],
)
def test_a_start_value_that_would_be_lost_is_a_mistake(tmp_path: Path, entry: str, said: str) -> None:
    """It was 0 without a word; `initial: 5` with a scale of 10 usually means the number in the register."""
    assert f"initial: {said}" in refused(tmp_path, entry)


@pytest.mark.parametrize(
    "entry",
    [
        "scale: 10, initial: 0",
        "scale: 10, initial: 6",
        "scale: 0.1, initial: 21.37",
        "type: f32, scale: 10, initial: 5",
    ],
)
def test_a_start_value_may_be_rounded(tmp_path: Path, entry: str) -> None:
    table = tmp_path / "table.yaml"
    table.write_text(f"holding_registers:\n  - {{address: 0, name: a, {entry}}}\n", encoding="utf-8")
    assert load_table(table)
