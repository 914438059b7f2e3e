"""S-0-0127: which values of CP2 a drive finds wrong, and what it says that it can have in its telegrams."""

import pytest

from fieldrig_devices.sercos.communication import Communication
from fieldrig_devices.sercos.datum import Datum, IdnTable
from fieldrig_devices.sercos.idn import READ_ONLY, Attribute, Format, Length

FOUR, WORD = Length.FOUR, Length.TWO
RIGHT = {1: 4_000, 2: 4_000, 6: 100, 89: 400, 8: 700, 7: 3_800, 9: 1, 10: 24, 15: 7}
"""Two drives share the MDT; this one's record is the first."""


def data_of(**values: int) -> Communication:
    """Lay these IDNs over those of `RIGHT`, as in s89=400."""
    feedback = Attribute(FOUR, Format.SIGNED, protected=READ_ONLY)
    table = IdnTable(
        [
            Datum(47, "position command value", Attribute(FOUR, Format.SIGNED)),
            Datum(36, "velocity command value", Attribute(FOUR, Format.SIGNED)),
            Datum(51, "position feedback value 1", feedback),
            Datum(40, "velocity feedback value", feedback),
            Datum(30, "manufacturer version", Attribute(Length.LIST_OF_BYTES, Format.TEXT), "V1"),
            Datum(99, "reset class 1 diagnostic", Attribute(WORD, Format.BINARY, is_command=True)),
        ]
    )
    data = Communication(table, lambda: 2, lambda _phase, _command: None, lambda _has_ended: None)
    for idn, value in (RIGHT | {int(name[1:]): value for name, value in values.items()}).items():
        table[idn].set(value)
    table[24].set((47,))
    table[16].set((51, 40))
    return data


def test_right_values_are_found_right() -> None:
    assert data_of().invalid() == []


@pytest.mark.manual("PD-133")
@pytest.mark.parametrize(
    ("values", "invalid"),
    [
        ({"s1": 3_000, "s2": 3_000}, [1, 2, 7]),
        ({"s1": 0, "s2": 0}, [1, 2, 6, 7, 8, 89]),
        ({"s1": 2_000, "s2": 4_000}, [1]),  # not a multiple
        ({"s1": 4_000, "s2": 2_000, "s7": 1_900}, []),
        ({"s6": 9}, [6]),  # t1min is 10
        ({"s6": 10}, []),
        ({"s6": 395}, [89]),  # less than tATMT, 10, before the MDT
        ({"s6": 390}, []),
        ({"s8": 400}, [8]),  # the command value counts before it is there
        ({"s8": 429}, [8]),  # tMTSG, 30, to take it over
        ({"s8": 430}, []),
        ({"s7": 3_901}, [7]),  # t4min is 100
        ({"s7": 3_900}, []),
        ({"s89": 4_000, "s8": 4_001}, [8, 89]),
        ({"s8": 4_000}, []),  # with the end of the cycle at the latest
        ({"s89": 3_981, "s8": 4_000}, [8, 89]),  # tMTSY, 20, before the next MST
        ({"s15": 8 + 6}, []),  # of more bits the low three pick the telegram
        ({"s9": 18}, [9, 10]),  # 8 bytes do not fit behind byte 17 of 24
        ({"s9": 17}, []),
        ({"s10": 7}, [9, 10]),
    ],
)
def test_wrong_values_are_named(values: dict[str, int], invalid: list[int]) -> None:
    assert data_of(**values).invalid() == invalid


@pytest.mark.parametrize(
    ("mdt", "at", "invalid"),
    [
        ((47, 36), (51, 40), []),
        ((47, 80), (51,), [24]),  # there is no 80
        ((51,), (51,), [24]),  # it cannot be written
        ((30,), (30,), [16, 24]),  # a text
        ((99,), (99,), [16, 24]),  # a command
        ((47,) * 9, (51,) * 9, [16, 24]),  # 32 bytes are the most
        ((), (), []),
    ],
)
def test_lists_of_telegrams_are_checked(mdt: tuple[int, ...], at: tuple[int, ...], invalid: list[int]) -> None:
    data = data_of(s10=100)
    data._table[24].set(mdt)
    data._table[16].set(at)
    assert data.invalid() == invalid


def test_standard_telegrams_need_their_values() -> None:
    assert data_of(s15=5).invalid() == []
    assert data_of(s15=1).invalid() == [15], "there is no torque command value"


def test_what_may_be_in_a_telegram_is_told() -> None:
    table = data_of()._table
    assert {47, 36, 51, 40, 14, 28} <= set(table[187].numbers)
    assert not {30, 99, 16} & set(table[187].numbers)
    assert {47, 36} <= set(table[188].numbers)
    assert not {51, 40, 14, 1, 99} & set(table[188].numbers)
    assert table[25].numbers == [99, 127, 128]
    assert table[18].numbers == [1, 2, 6, 7, 8, 9, 10, 15, 16, 24, 89]
