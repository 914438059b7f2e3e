"""One layout for programs of the ARP, which changes blanks only."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from fieldrig.system.exits import Exit
from fieldrig_devices.arp.commands import app
from fieldrig_devices.arp.language.formatter import formatted, strangers
from fieldrig_devices.arp.language.parser import parse
from fieldrig_devices.arp.language.tokens import LONGEST_LINE, tokens

PROGRAMS = sorted((Path(__file__).parents[4] / "configs/programs").glob("*.I0*"))
LINES = [
    ("  beg  main", "beg main"),
    ("v1==2", "  v1 == 2"),
    (" V[V1+2]  ==-3.50", "  V[V1 + 2] == -3.50"),
    ("V1 == ( V2-V3 )*-V4", "  V1 == (V2 - V3) * -V4"),
    ("V1 == SIN( V2 )%5", "  V1 == SIN(V2) % 5"),
    ("LOOP :if V1>=3 , GOTO LOOP", "LOOP: if V1 >= 3, GOTO LOOP"),
    ("  WAIT:", "WAIT:"),
    ("ON1 F1&/F299,COUNT;the nip", "  ON1 F1 & /F299, COUNT         ;the nip"),
    ("ON2 F1 & ( \\ I3 ) COUNT", "  ON2 F1 & (\\I3) COUNT"),
    ("V1 == @TIME[ V2 ]", "  V1 == @TIME[V2]"),
    ('MSG 1,"a  b , c"', '  MSG 1, "a  b , c"'),
    ("  ; a comment", "  ; a comment"),
    ("; a comment", "; a comment"),
]


@pytest.mark.parametrize(("line", "expected"), LINES)
def test_a_line_has_even_blanks(line: str, expected: str) -> None:
    head = "" if "beg" in line else "BEG MAIN\n"
    assert formatted(f"{head}{line}\nEND\n") == f"{head}{expected}\nEND\n"


def test_names_of_equ_are_as_wide_as_their_neighbours() -> None:
    text = "A EQU V1 ; first\nLONGER   EQU V2\n\nB EQU V3\nBEG M\nEND"
    expected = f"{'A      EQU V1':<32}; first\nLONGER EQU V2\n\nB EQU V3\nBEG M\nEND\n"
    assert formatted(text) == expected


def test_several_empty_lines_are_one() -> None:
    assert formatted("\n\nBEG M\r\n\r\n\r\nEND\r\n\n") == "BEG M\n\nEND\n"


@pytest.mark.parametrize("file", PROGRAMS, ids=lambda file: file.name)
def test_the_shipped_programs_have_the_layout(file: Path) -> None:
    text = file.read_text(encoding="ascii")
    assert formatted(text) == text


def test_a_line_never_gets_too_long() -> None:
    line = "V1==" + "+".join(["V1"] * 38)
    assert len(line) < LONGEST_LINE < len("  V1 == " + " + ".join(["V1"] * 38))
    assert formatted(f"BEG M\n{line}\nEND\n") == f"BEG M\n{line}\nEND\n"


WORDS = ["V1", "F2", "BEG", "END", "IF", "EQU", "NAME", "SIN", "@TIME", "#1", "12", "0.5", '"a ;b"', "H0F"]
SIGNS = ["==", "+", "-", "*", "/", "\\", "%", "&", "!", "<", ">=", "(", ")", "[", "]", ",", ":", ";", "; text"]
LINE = st.lists(st.tuples(st.sampled_from([*WORDS, *SIGNS]), st.sampled_from(["", " ", "\t", "   "])), max_size=8)


@given(st.lists(LINE, max_size=6))
def test_no_text_gets_other_tokens_and_a_second_time_changes_nothing(parts: list[list[tuple[str, str]]]) -> None:
    text = "\n".join("".join(f"{word}{blank}" for word, blank in line) for line in parts)
    if strangers(text):
        return
    once = formatted(text)
    assert formatted(once) == once
    assert _meaning(once) == _meaning(text)
    assert len(parse(once)[1]) == len(parse(text)[1])


def _meaning(text: str) -> list[object]:
    """Return the tokens of all lines that have some, and the comments."""
    found: list[object] = []
    for line in text.splitlines():
        *inside, end = tokens(line)
        comment = line[end.column - 1 :].strip()
        if inside or comment:
            found.append(([(one.kind, one.text) for one in inside], comment))
    return found


def test_the_command_formats_files_and_checks_them(tmp_path: Path) -> None:
    file, wrong = tmp_path / "cam.I01", tmp_path / "wrong.I01"
    file.write_text("BEG M\nV1==2\nEND\n")
    wrong.write_text("BEG M\nV1 == ?\nEND\n")
    run = CliRunner().invoke
    assert run(app, ["fmt", str(file), "--check"]).exit_code == Exit.WRONG
    assert file.read_text() == "BEG M\nV1==2\nEND\n"
    done = run(app, ["fmt", str(file)])
    assert (done.exit_code, done.stdout) == (0, f"{file}: formatted\n")
    assert file.read_text() == "BEG M\n  V1 == 2\nEND\n"
    assert run(app, ["fmt", str(file), "--check"]).exit_code == 0
    refused = run(app, ["fmt", str(wrong)])
    assert refused.exit_code == Exit.WRONG
    assert '"?" has no meaning here' in refused.stderr
    assert wrong.read_text() == "BEG M\nV1 == ?\nEND\n"


def test_the_standard_input_goes_to_the_standard_output() -> None:
    done = CliRunner().invoke(app, ["fmt", "-"], input="BEG M\nV1==2\nEND\n")
    assert done.stdout == "BEG M\n  V1 == 2\nEND\n"
