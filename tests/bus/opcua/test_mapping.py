"""Nodes, types, units and values in the terms of OPC UA, without a server."""

from datetime import UTC, datetime

import pytest
from asyncua import ua

from fieldrig_bus.opcua.mapping import (
    STATUS_CODES,
    WrongValueError,
    engineering_units,
    from_variant,
    mapped,
    to_variant,
    value_range,
)
from fieldrig_bus.opcua.message import AnyValue, Node, Status

T = ua.VariantType

# OPC 30000 (PLCopen information model), table of elementary types; DataTypes by their numbers in OPC 10000-6, annex A.
TYPES = [
    ("BOOL", T.Boolean, 1), ("SINT", T.SByte, 2), ("USINT", T.Byte, 3), ("BYTE", T.Byte, 3), ("INT", T.Int16, 4),
    ("UINT", T.UInt16, 5), ("WORD", T.UInt16, 5), ("DINT", T.Int32, 6), ("UDINT", T.UInt32, 7), ("DWORD", T.UInt32, 7),
    ("LINT", T.Int64, 8), ("ULINT", T.UInt64, 9), ("LWORD", T.UInt64, 9), ("REAL", T.Float, 10),
    ("LREAL", T.Double, 11),
    ("STRING", T.String, 12), ("WSTRING", T.String, 12), ("CHAR", T.Byte, 3), ("WCHAR", T.UInt16, 5),
    ("DT", T.DateTime, 13), ("DATE", T.DateTime, 13), ("TOD", T.DateTime, 13),
    ("TIME", T.Double, 290),
]  # fmt: skip


@pytest.mark.parametrize(("name", "variant", "number"), TYPES)
def test_an_iec_type_has_its_data_type(name: str, variant: ua.VariantType, number: int) -> None:
    found = mapped(Node("x", "", "x", type=name))
    assert (found.variant, found.data_type) == (variant, number)


# OPC 10000-8, 5.6.3: the UnitId is the UNECE code as a number, for example MMT is 5066068 and SEC 5457219.
@pytest.mark.parametrize(("unit", "number"), [("mm", 5066068), ("s", 5457219), ("°C", 4408652), ("V", 5655636)])
def test_a_unit_is_a_unece_code(unit: str, number: int) -> None:
    found = engineering_units(unit)
    assert (found.UnitId, found.DisplayName.Text) == (number, unit)
    assert found.NamespaceUri == "http://www.opcfoundation.org/UA/units/un/cefact"


def test_a_unit_without_a_code_has_its_text_only() -> None:
    assert (engineering_units("unit/s").UnitId, engineering_units("unit/s").DisplayName.Text) == (-1, "unit/s")


DATES = [
    ("DT", 86_400, datetime(1970, 1, 2, tzinfo=UTC)),
    ("DATE", 951_782_400, datetime(2000, 2, 29, tzinfo=UTC)),
    ("TOD", 3_600_001, datetime(1970, 1, 1, 1, 0, 0, 1_000, tzinfo=UTC)),
]


@pytest.mark.parametrize(("name", "value", "shown"), DATES)
def test_dates_are_date_times(name: str, value: int, shown: datetime) -> None:
    node = Node("x", "", "x", type=name)
    assert to_variant(node, value).Value == shown
    assert from_variant(node, ua.Variant(shown, T.DateTime)) == value
    assert from_variant(node, ua.Variant(shown.replace(tzinfo=None), T.DateTime)) == value


def test_a_time_is_a_duration_in_milliseconds() -> None:
    node = Node("x", "", "x", type="TIME")
    assert to_variant(node, 1_500) == ua.Variant(1_500.0, T.Double)
    assert from_variant(node, ua.Variant(2.6, T.Double)) == 3


WRONG: list[tuple[Node, ua.Variant, Status]] = [
    (Node("x", "", "x", type="INT"), ua.Variant(1, T.Int32), Status.TYPE_MISMATCH),
    (Node("x", "", "x", type="BOOL"), ua.Variant(1, T.Byte), Status.TYPE_MISMATCH),
    (Node("x", "", "x", type="REAL"), ua.Variant(1.0, T.Double), Status.TYPE_MISMATCH),
    (Node("x", "", "x", type="INT"), ua.Variant([1], T.Int16), Status.TYPE_MISMATCH),
    (Node("x", "", "x", type="INT", length=2), ua.Variant(1, T.Int16), Status.TYPE_MISMATCH),
    (Node("x", "", "x", type="INT", length=2), ua.Variant([1, 2, 3], T.Int16), Status.OUT_OF_RANGE),
    (Node("x", "", "x", type="INT", low=0, high=10), ua.Variant(11, T.Int16), Status.OUT_OF_RANGE),
    (Node("x", "", "x", type="TIME"), ua.Variant(-1.0, T.Double), Status.OUT_OF_RANGE),
    (Node("x", "", "x", type="TIME"), ua.Variant(float("nan"), T.Double), Status.OUT_OF_RANGE),
    (Node("x", "", "x", type="TOD"), ua.Variant(datetime(1970, 1, 2, tzinfo=UTC), T.DateTime), Status.OUT_OF_RANGE),
    (Node("x", "", "x", type="DATE"), ua.Variant(datetime(1969, 1, 1, tzinfo=UTC), T.DateTime), Status.OUT_OF_RANGE),
    (Node("x", "", "x", choices=(("a", 0), ("b", 1))), ua.Variant(2, T.Int32), Status.OUT_OF_RANGE),
]


@pytest.mark.parametrize(("node", "variant", "status"), WRONG)
def test_a_wrong_value_has_its_status(node: Node, variant: ua.Variant, status: Status) -> None:
    with pytest.raises(WrongValueError) as wrong:
        from_variant(node, variant)
    assert wrong.value.status is status


GOOD: list[tuple[Node, AnyValue]] = [
    (Node("x", "", "x", type="INT", low=0, high=10), 10),
    (Node("x", "", "x", type="REAL"), float("inf")),
    (Node("x", "", "x", type="STRING"), "belt ä"),
    (Node("x", "", "x", type="BOOL", length=3), [True, False, True]),
    (Node("x", "", "x", choices=(("a", 0), ("b", 7))), 7),
]


@pytest.mark.parametrize(("node", "value"), GOOD)
def test_a_value_comes_back(node: Node, value: AnyValue) -> None:
    assert from_variant(node, to_variant(node, value)) == value


def test_a_range_is_shown_only_if_it_is_narrower_than_the_type() -> None:
    assert value_range(Node("x", "", "x", type="INT")) is None
    assert value_range(Node("x", "", "x", type="INT", low=1, high=5)) == ua.Range(Low=1, High=5)


def test_every_status_has_a_code() -> None:
    assert STATUS_CODES.keys() == set(Status)
    assert STATUS_CODES[Status.NOT_WRITABLE] == 0x803B0000  # OPC 10000-6, annex A.2
    assert STATUS_CODES[Status.TYPE_MISMATCH] == 0x80740000
    assert STATUS_CODES[Status.OUT_OF_RANGE] == 0x803C0000
