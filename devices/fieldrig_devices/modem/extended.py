"""Extended commands (`+NAME`) of a modem: parameters with their fields, and texts.

Source: ITU-T V.250, 5.4 (syntax), 6.1 (identification), 6.2.10 (+IPR), 6.4.1 (+MS); T.31 for +FCLASS.  `+MS=,0`, which
PD-249 sends, turns automatic modulation off.  A field that is left out keeps its value.
Left out: +DR, +DS, +ER, +ES, +ICF, +IFC, +ILRR and everything of other recommendations.
"""

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

from fieldrig_bus.telephone.modulation import FASTEST_BPS, RATES

Value = int | str
DTE_RATES: Final = (300, 600, 1200, 2400, 4800, 9600, 19_200, 38_400, 57_600, 115_200, 230_400)


class Field(NamedTuple):
    default: Value
    choices: Sequence[Value]
    shown: str
    """The choices as the test command shows them."""


MOST: Final = tuple(range(FASTEST_BPS + 1))
PARAMETERS: Final[Mapping[str, tuple[Field, ...]]] = {
    "+MS": (
        Field("V34", tuple(RATES), f"({','.join(RATES)})"),
        Field(1, (0, 1), "(0,1)"),
        *(Field(0, MOST, f"(0,300-{FASTEST_BPS})") for _ in ("tx min", "tx max", "rx min", "rx max")),
    ),
    "+IPR": (Field(0, (0, *DTE_RATES), f"(0,{','.join(map(str, DTE_RATES))})"),),
    "+FCLASS": (Field(0, (0,), "(0)"),),
}
"""Fields of the parameters: modulation, automatic modulation and limits in bit/s (0: none); rate of the serial line
(0: as the terminal's); service class (data)."""
ROCKWELL_ONLY: Final = frozenset({"+MS"})
"""Commands that modems with another chip set refuse (PD-270)."""
TEXTS: Final[Mapping[str, str]] = {
    "+GMI": "fieldrig",
    "+GMM": "telephone modem, 33600 bit/s",
    "+GMR": "1",
    "+GCAP": "+GCAP: +FCLASS,+MS",
}


def with_fields(name: str, present: tuple[Value, ...], given: Sequence[str]) -> tuple[Value, ...] | None:
    """Return the values of a parameter after `+NAME=given`; None if that is an error."""
    fields = PARAMETERS[name]
    if len(given) > len(fields):
        return None
    values = list(present)
    for place, text in enumerate(given):
        if text == "":
            continue
        value = _value(fields[place], text)
        if value is None:
            return None
        values[place] = value
    return tuple(values)


def fitting(name: str, values: Sequence[Value]) -> bool:
    """Return whether these are values of the parameter."""
    fields = PARAMETERS[name]
    return len(values) == len(fields) and all(
        type(value) is type(field.default) and value in field.choices
        for field, value in zip(fields, values, strict=True)
    )


def _value(field: Field, text: str) -> Value | None:
    value: Value = text.strip('"').upper()
    if isinstance(field.default, int):
        if not (text.isascii() and text.isdigit()):
            return None
        value = int(text)
    return value if value in field.choices else None


def shown_test(name: str) -> str:
    return f"{name}: {','.join(field.shown for field in PARAMETERS[name])}"


def shown_value(name: str, values: Sequence[Value]) -> str:
    return f"{name}: {','.join(map(str, values))}"
