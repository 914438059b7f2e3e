"""Directives: names for numbers and masks, and included files."""

from pathlib import Path

import pytest
from pam_programs import HEADER, MACHINE, mistakes_of

from fieldrig.text.source_text import decoded
from fieldrig_devices.pam.application_files import reader_beside
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
        ('#include "STIERROR.SYS"\n#set N RESOLVER_FAILURE\n', 0x800000),  # manual line 9058
        ('#include "C:\\PAM\\SYS\\StIError.Sys"\n#set N RESOLVER_FAILURE\n', 0x800000),
        ("#include <smarterr.sys>\n#set N OUT_OVERTEMP_1\n", 0x10),
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
        ('#include "C:\\PAM\\none.pam"', "write its name without the drive."),
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


def test_files_are_included_as_they_lie_on_an_old_disk(tmp_path: Path) -> None:
    for name, content in {
        "MAIN.PAM": HEADER.encode()
        + b'#include "inc\\defs.pam"\r\nINTERNAL FLAG_VAR IFV_a; NUMBER = N\x81; END\r\n\x1a\x1aEND',
        "Inc/DEFS.PAM": b'#include "more.h"\r\n#set N\x81 M | 4\r\n\x1a\0\0\0',
        "Inc/More.h": b"// \xc4\xc4\xc4\xc4\xc4\r\n#define M 2\x1a",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    source = tmp_path / "MAIN.PAM"
    program, found = checked(decoded(source.read_bytes()), source.name, reader_beside(source))
    assert [str(wrong) for wrong in found] == []
    item = program.items[-1]
    assert isinstance(item, Declaration)
    assert item.parameters[0].values == (Number(item.place, 6),)


@pytest.mark.manual("PAMS-050")
def test_masks_of_a_user_are_added_to_those_of_a_system_file() -> None:
    """Manual line 8839: a global mask is defined in ST1ERROR.SYS itself."""
    files = {"st1error.sys": "#set MINE OVER | 1\n".replace("OVER", "#2")}
    text = '#include "st1error.sys"\n#set N MINE | RESOLVER_FAILURE\n' + HEADER + VARIABLE.format("N")
    program, found = checked(text, "x", files.get)
    assert found == []
    item = program.items[1]
    assert isinstance(item, Declaration)
    assert item.parameters[0].values == (Number(item.place, 0x80_0003),)


def test_a_file_that_cannot_be_read_is_a_mistake() -> None:
    def read(name: str) -> str:
        raise ValueError(f"{name} cannot be read: Permission denied")

    assert "a.pam cannot be read: Permission denied" in str(checked('#include "a.pam"\n', "x", read)[1][0])
