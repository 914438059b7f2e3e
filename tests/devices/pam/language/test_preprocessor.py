"""Directives: names for numbers and masks, and included files."""

import pytest
from pam_programs import HEADER, MACHINE, mistakes_of

from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.items import Declaration
from fieldrig_devices.pam.language.tree import Number

VARIABLE = "INTERNAL FLAG_VAR IFV_a; NUMBER = {}; END\n"


def number(text: str) -> object:
    """The value of NUMBER of the first variable."""
    program, mistakes = checked(text, "x")
    assert not mistakes, mistakes
    item = program.items[1]
    assert isinstance(item, Declaration)
    value = item.parameters[0].values[0]
    assert isinstance(value, Number)
    return value.value


@pytest.mark.manual("PAMS-050")
@pytest.mark.parametrize(
    ("directives", "value"),
    [
        ("#define N 5\n", 5),
        ("#define M 6\n#define N M\n", 6),
        ("#set N 1 | 4 | #10\n", 21),
        ("#set M 2\n#set N M | \\\n  8\n", 10),
        ("#define N 1\n#undef N\n#define N 2\n", 2),
        ('#include "SMARTERR.SYS"\n#set N OUT_OVERTEMP_1 | OUT_OVERTEMP_8\n', 0x810),
        ('#include "ST1ERROR.SYS"\n#set N HARD_ERROR\n', 0xF81000),
        ("#include st1error.sys\n#set N RESOLVER_FAILURE\n", 0x800000),
    ],
)
def test_names(directives: str, value: int) -> None:
    assert number(directives + HEADER + VARIABLE.format("N")) == value


@pytest.mark.parametrize(
    ("directive", "said"),
    [
        ("#define N 1\n#define N 2", "Write #undef N first."),
        ("#undef N", "N is not defined yet"),
        ("#set N OVER_VOLTAGE", 'OVER_VOLTAGE is defined in ST1ERROR.SYS: write #include "ST1ERROR.SYS".'),
        ("#set N 1 |", "the masks of N are not complete"),
        ("#set N 1 2", "got 2; expected |"),
        ("#define", "#define has no name"),
        ('#include "none.pam"', "there is no file none.pam"),
    ],
)
def test_wrong_directives(directive: str, said: str) -> None:
    assert said in str(mistakes_of(f"{directive}\n{MACHINE}")[0])


def test_included_files_and_their_places() -> None:
    files = {"nodes.pam": "NODE NOD_a; ADDRESS = 1; TYPE = ST2; END"}
    found = checked(f'{HEADER}#include "nodes.pam"\n', "x.pam", files.get)[1]
    assert [(mistake.file, mistake.line) for mistake in found] == [("nodes.pam", 1)]


def test_a_file_that_includes_itself_is_refused() -> None:
    found = checked('#include "a"\n', "x", {"a": '#include "a"\n'}.get)[1]
    assert "at most 10 files in each other" in str(found[0])


def test_names_that_grow_without_end_are_refused() -> None:
    doubling = "#define A0 1 + 1\n" + "".join(f"#define A{n + 1} A{n} + A{n}\n" for n in range(12))
    assert "is too long" in str(checked(doubling, "x")[1][0])
