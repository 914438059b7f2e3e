"""Lines of several extended commands: what is set, what is kept, and where a line ends (ITU-T V.250, 5.4 and 5.7)."""

from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from modem_bench import ModemBench

# Ranges of V.250: 6.2.12 +IFC, 6.2.13 +ILRR, 6.4.2 +MR, 6.5.5 +ER, 6.6.2 +DR; the others as the test commands say.
RANGES: dict[str, tuple[list[int], ...]] = {
    "+IFC": ([0, 1, 2, 3], [0, 1, 2]),
    "+ICF": (list(range(7)), [0, 1, 2, 3]),
    "+ILRR": ([0, 1],),
    "+MR": ([0, 1],),
    "+ES": ([0, 1, 2, 3], [0, 2, 3], [0, 1, 2, 4, 5]),
    "+ER": ([0, 1],),
    "+DS": ([0, 1, 2, 3], [0], [512, 513, 2048], [6, 7, 250]),
    "+DR": ([0, 1],),
}
DEFAULTS = {
    "+IFC": [2, 2], "+ICF": [0, 1], "+ILRR": [0], "+MR": [0], "+ES": [3, 0, 2], "+ER": [0], "+DS": [3, 0, 2048, 32],
    "+DR": [0],
}  # fmt: skip
OUTSIDE = {"+DS": [4, 1, 511, 2049, 5, 251], "+ES": [4, 1, 3, 6], "+IFC": [4, 3], "+ICF": [7, 4]}

WITH_PARITY = (2, 5)
"""Formats of +ICF with a parity bit (V.250, 6.2.11)."""
MARK_AND_SPACE = (2, 3)
"""Parities that a serial line of a rig does not have."""


@dataclass(frozen=True)
class Given:
    """A command that sets fields; None leaves one out.  `wrong` is a field that is none."""

    name: str
    fields: tuple[str | None, ...]
    wrong: str | None

    @property
    def text(self) -> str:
        return f"{self.name}={','.join(field or '' for field in (*self.fields, *filter(None, [self.wrong])))}"


@st.composite
def commands(draw: st.DrawFn) -> Given:
    name = draw(st.sampled_from(sorted(RANGES)))
    choices = [st.one_of(st.none(), st.sampled_from(allowed).map(str)) for allowed in RANGES[name]]
    count = draw(st.integers(1, len(choices)))
    fields = tuple(draw(choice) for choice in choices[:count])
    wrongs = ["X", "-1", "1.0", "9999999", '"1"'] if count < len(choices) else ["0", ""]  # one field too many
    wrong = draw(st.sampled_from([None, None, None, *wrongs]))
    return Given(name, fields, wrong or None)


@settings(deadline=None, max_examples=60)
@given(st.lists(commands(), min_size=1, max_size=5), st.booleans(), st.booleans())
def test_commands_of_a_line_are_carried_out_up_to_a_mistake(line: list[Given], is_spaced: bool, is_small: bool) -> None:
    bench = ModemBench()
    text = (" ; " if is_spaced else ";").join(command.text for command in line)
    text = text.lower() if is_small else text
    expected = {name: list(values) for name, values in DEFAULTS.items()}
    result = "OK"
    for command in line:
        if command.wrong is not None:
            result = "ERROR"
            break
        values = list(expected[command.name])
        for at, field in enumerate(command.fields):
            if field is not None:
                values[at] = int(field)
        if command.name == "+ICF" and values[0] in WITH_PARITY and values[1] in MARK_AND_SPACE:
            result = "ERROR"
            break
        expected[command.name] = values
    assert bench.result(f"AT{text}") == result
    shown = bench.lines_of(f"AT{';'.join(f'{name}?' for name in RANGES)}")
    assert shown == [*(f"{name}: {','.join(map(str, expected[name]))}" for name in RANGES), "OK"]


@pytest.mark.parametrize("name", RANGES)
def test_each_field_takes_its_range_and_no_more(name: str) -> None:
    for at, allowed in enumerate(RANGES[name]):
        for value in {*range(8), *OUTSIDE.get(name, ()), *allowed}:
            result = ModemBench().result(f"AT{name}={',' * at}{value}")
            assert result == ("OK" if value in allowed else "ERROR"), (at, value)


@pytest.mark.parametrize("first", range(7))
@pytest.mark.parametrize("parity", range(4))
def test_a_parity_counts_only_in_a_format_that_has_one(first: int, parity: int) -> None:
    """V.250, 6.2.11: "if present"; 3,3 is its own recommendation, and what drivers of modems send."""
    bench = ModemBench()
    is_possible = first not in WITH_PARITY or parity not in MARK_AND_SPACE
    assert bench.result(f"AT+ICF={first},{parity}") == ("OK" if is_possible else "ERROR")
    assert bench.lines_of("AT+ICF?") == [f"+ICF: {first},{parity}" if is_possible else "+ICF: 0,1", "OK"]
    bench.ask("AT+ICF=3,3")
    assert bench.result(f"AT+ICF={first}") == ("ERROR" if first in WITH_PARITY else "OK")


@pytest.mark.parametrize("bps", [1, 299, 33_601])
def test_a_rate_that_the_test_command_does_not_show_is_an_error(bps: int) -> None:
    for commas in range(4):
        assert ModemBench().result(f"AT+MS=,,{',' * commas}{bps}") == "ERROR"


@pytest.mark.parametrize(
    ("line", "answers"),
    [
        ("AT+MR=1;E0+ER?", ["+ER: 0", "OK"]),
        ("AT+MR?;+ER=?;+DR?", ["+MR: 0", "+ER: (0,1)", "+DR: 0", "OK"]),
        ("AT+MR?+ER?", ["ERROR"]),  # an extended command ends with a semicolon or the line (5.4.3)
        ("AT+MR=1+ER=1", ["ERROR"]),
        ("AT+MR?;+XYZ?;+ER?", ["+MR: 0", "ERROR"]),
        ("AT+MR?;", ["+MR: 0", "OK"]),
        ("AT+mr = 1 ; +mr ?", ["+MR: 1", "OK"]),
        ("AT+MR=2;+MR?", ["ERROR"]),
        ("ATE1+MR?;S0?", ["+MR: 0", "000", "OK"]),
    ],
)
def test_lines_with_several_commands(line: str, answers: list[str]) -> None:
    assert ModemBench().lines_of(line) == answers
