"""The listings of the manual's 5.12 (acceptance case ARP-A18), from the program to the screen and the printer."""

from collections.abc import Iterator

import pytest
from arp_terminal import CellBench

from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.languages.mistakes import CompileError

# Manual 5.12 after MSG and TERM, with a second `;` (digest I-53) and without V1001 (I-28).
SERIES = """
TERM                                ;it deletes the screen page
MSG 35, “AUTOMATIC CYCLE”
TERM 4, 1, 1, 35                    ;line=4, col.=1, height=1, message=35 (“AUTOMATIC CYCLE”)
MSG 2, “LENGTH: = #####.#”
TERM 2, 22, 3, 2, V100              ;line=2, col.=22, height=3, message = 2, it displays V100 in the format 9999,9
TERM 5, 2, 2, 2, V100, E           ;line=5, col.=2, height=2, it displays V100 with the possibility to change the
                                   ;value in standard mode
TERM 6, 4, 2, V4                    ;displaying of the index message
"""
ERASING = "TERM 6, 8                           ;it deletes the message in position line=6, col.=8"
PRINTS = """
MSG 35, “AUTOMATIC CYCLE”
PRINT 35 ;it prints the message “AUTOMATIC CYCLE”
MSG 2, “LENGTH: = #####.#”
PRINT 2, V100 ;it prints V100 in 9999,9 format (“LENGTH: = 9999.9”).
"""


@pytest.fixture
def cell() -> Iterator[CellBench]:
    with CellBench(time="2026-11-21T10:15:00").after(100) as cell:
        cell.card.V[100], cell.card.V[4] = 9_999_900, 35_000
        yield cell


@pytest.mark.manual("ARP-114", "ARP-115", "ARP-119")
def test_series_of_term_and_msg_makes_this_screen(cell: CellBench) -> None:
    cell.program(SERIES)
    assert cell.screen == [
        "",
        "",  # column 22 is off the screen
        "",
        "AUTOMATIC CYCLE",
        " L E N G T H :",
        "   A U T O M A T",
        "",
        "",
    ]
    assert cell.rig.get("tr", "texts") == "\n".join(
        ["4 1 1 AUTOMATIC CYCLE", "2 22 3 LENGTH: =  9999.", "5 2 2 LENGTH: =  9999.", "6 4 2 AUTOMATIC CYCLE"]
    )
    assert cell.errors.error == 0


@pytest.mark.manual("ARP-115")
def test_column_22_is_warning_3_and_what_fits_is_shown(cell: CellBench) -> None:
    cell.program(SERIES)
    assert cell.card.warnings == [203]  # digest I-27, and nothing else
    cell.program("TERM 1, 0, 1, 35")
    assert (cell.card.warnings, cell.screen[0]) == ([203, 203], "UTOMATIC CYCLE")
    cell.program("TERM 0, 1, 2, 35")
    assert (cell.card.warnings, cell.screen[0]) == ([203] * 3, "A U T O M A T I")
    cell.program("TERM 9, 1")
    assert cell.card.warnings == [203] * 4


@pytest.mark.manual("ARP-115")
def test_message_is_erased_at_its_place(cell: CellBench) -> None:
    cell.program(SERIES + "TERM 6, 8, 1, 35")
    assert cell.screen[5] == "   A U AUTOMATIC"
    cell.program(ERASING)
    assert cell.screen[5] == "   A U T O M A T"


@pytest.mark.long
@pytest.mark.manual("ARP-114")
def test_message_of_17_characters_is_cut_with_a_note(cell: CellBench) -> None:
    compiled = compile_text(f"BEG MAIN\n{SERIES}\nEND")
    assert any("17 characters" in note.what for note in compiled.notes)  # digest I-26
    cell.program(SERIES)
    assert cell.rig.get("tr", "message.2") == "LENGTH: = #####."


def test_v1001_is_a_mistake() -> None:
    with pytest.raises(CompileError, match="V1001"):  # digest I-28
        compile_text("BEG MAIN\nTERM 6, 8, 3, 24, V1001, P\nEND")


def test_term_where_print_is_meant_is_a_mistake() -> None:
    with pytest.raises(CompileError):  # digest I-29
        compile_text("BEG MAIN\nTERM 2, V100\nEND")


@pytest.mark.manual("ARP-116")
def test_series_of_print_makes_these_lines(cell: CellBench) -> None:
    cell.program(PRINTS + "PRINT 0")
    assert str(cell.rig.get("tr", "printer")).split("\n") == [
        "AUTOMATIC CYCLE",
        "LENGTH: =  9999.",
        "21/11/2026",
        "10:15:00",
    ]
