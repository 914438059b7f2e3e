"""Extended commands (`+NAME`) of a modem: parameters with their fields, and texts.

Source: ITU-T V.250, 5.4 (syntax), 6.1 (identification), 6.2.10 to 6.2.13 (+IPR, +ICF, +IFC, +ILRR), 6.4 (+MS, +MR), 6.5
(+ES, +ER), 6.6 (+DS, +DR); T.31 for +FCLASS.  `+MS=,0`, which PD-249 sends, turns automatic modulation off.  A field
that is left out keeps its value.  Some parameters are the same setting as a basic command (`TWINS`).
Left out: everything of other recommendations; of V.250, direct mode, MNP, compression, and parity by mark and space.
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


LIMIT_BPS: Final = (0, *range(300, FASTEST_BPS + 1))
PARAMETERS: Final[Mapping[str, tuple[Field, ...]]] = {
    "+MS": (
        Field("V34", tuple(RATES), f"({','.join(RATES)})"),
        Field(1, (0, 1), "(0,1)"),
        *(Field(0, LIMIT_BPS, f"(0,300-{FASTEST_BPS})") for _ in ("tx min", "tx max", "rx min", "rx max")),
    ),
    "+IPR": (Field(0, (0, *DTE_RATES), f"(0,{','.join(map(str, DTE_RATES))})"),),
    "+FCLASS": (Field(0, (0,), "(0)"),),
    "+ICF": (Field(0, range(7), "(0-6)"), Field(1, range(4), "(0-3)")),
    "+IFC": (Field(2, range(4), "(0-3)"), Field(2, range(3), "(0-2)")),
    "+ILRR": (Field(0, (0, 1), "(0,1)"),),
    "+MR": (Field(0, (0, 1), "(0,1)"),),
    "+ES": (Field(3, range(4), "(0-3)"), Field(0, (0, 2, 3), "(0,2,3)"), Field(2, (0, 1, 2, 4, 5), "(0,1,2,4,5)")),
    "+ER": (Field(0, (0, 1), "(0,1)"),),
    "+DS": (
        Field(3, range(4), "(0-3)"),
        Field(0, (0,), "(0)"),
        Field(2048, range(512, 2049), "(512-2048)"),
        Field(32, range(6, 251), "(6-250)"),
    ),
    "+DR": (Field(0, (0, 1), "(0,1)"),),
}
"""Fields of the parameters: modulation, automatic modulation and limits in bit/s (0: none); rate of the serial line
(0: as the terminal's); service class (data); format of the serial line (0: as the terminal's), its parity (odd, even,
mark, space); flow control of what the modem sends, and of what it receives; reports of the rate of the serial line,
and of the modulation; error correction of a caller, its necessity, and both for calls that come; report of error
correction; compression (recorded: it needs no negotiation, as there is none); report of compression."""
WITH_PARITY: Final = frozenset({2, 5})
"""Formats of +ICF with a parity bit; the parity of the others does not count (V.250, 6.2.11)."""
POSSIBLE_PARITIES: Final = frozenset({0, 1})
"""Parities that a serial line of a rig has."""
Twin = Mapping[int, tuple[Value, ...]]
TWINS: Final[Mapping[str, tuple[str, Twin]]] = {
    "&K": ("+IFC", {0: (0, 0), 3: (2, 2), 4: (1, 1)}),
    "\\N": (
        "+ES",
        {0: (1, 0, 1), 1: (0, 0, 0), 2: (3, 2, 4), 3: (3, 0, 2), 4: (3, 3, 5), 5: (2, 0, 2)},
    ),
}
"""Basic commands that set a parameter: its values by theirs.  A parameter sets the command in turn if one fits."""
ROCKWELL_ONLY: Final = frozenset({"+MS"})
"""Commands that modems with another chip set refuse (PD-270)."""
TEXTS: Final[Mapping[str, str]] = {
    "+GMI": "fieldrig",
    "+GMM": "telephone modem, 33600 bit/s",
    "+GMR": "1",
    "+GCAP": "+GCAP: +FCLASS,+MS,+ES,+DS",
}


def with_fields(name: str, present: tuple[Value, ...], given: Sequence[str]) -> tuple[Value, ...] | None:
    """Return the values of a parameter after `+NAME=given`; None if that is an error."""
    fields = PARAMETERS[name]
    if len(given) > len(fields):
        return None
    values = list(present)
    for index, text in enumerate(given):
        if text == "":
            continue
        value = _value(fields[index], text)
        if value is None:
            return None
        values[index] = value
    return tuple(values) if _agree(name, values) else None


def _agree(name: str, values: Sequence[Value]) -> bool:
    """Return whether the values of a parameter fit together."""
    if name == "+MS":
        return _has_rates(values)
    return name != "+ICF" or values[0] not in WITH_PARITY or values[1] in POSSIBLE_PARITIES


def _has_rates(modulation: Sequence[Value]) -> bool:
    """Return whether the lowest rates of +MS are not above the highest ones, of which 0 is no limit."""
    rates = [int(value) for value in modulation[2:]]
    highest = min((rate for rate in (rates[1], rates[3]) if rate), default=FASTEST_BPS)
    return max(rates[0], rates[2]) <= highest


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
