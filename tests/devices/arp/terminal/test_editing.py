"""The operator changes values: cursor, keys, password, and the report to the card.

The procedure is ours (docs/devices/arp/arp-terminal.md); manual 5.12 only says that values can be changed.
"""

import pytest
from arp_terminal import PRE_OPERATIONAL, START, CellBench, TerminalBench

pytestmark = pytest.mark.manual("ARP-115")

TWO_FIELDS = """
MSG 1, "A=##.#"
MSG 2, "B=###"
TERM 1, 1, 1, 1, V1, E
TERM 3, 2, 1, 2, V2, E
"""


@pytest.fixture
def bench() -> TerminalBench:
    """`A= 1.5` in line 1, which can be edited."""
    bench = TerminalBench(password="12")
    bench.store_message(1, "A=##.#")
    bench.send("314#01 01 01 01 00 05", "414#01 01 dc 05 00 00")
    assert bench.screen[0] == "A= 1.5"
    return bench


# Keys, text of line 1, and the edited values that were sent (place 1, 1; counter; value).
EDITS = [
    ("4 2 POINT 5 CR", "A=42.5", ["294#01 01 01 04 a6 00 00"]),
    ("MINUS 3 CR", "A=-3.0", ["294#01 01 01 48 f4 ff ff"]),
    ("CR 7 CR", "A= 7.0", ["294#01 01 01 58 1b 00 00"]),
    ("1 2 DEL 3 CR", "A=13.0", ["294#01 01 01 c8 32 00 00"]),
    ("1 2 3 4 CR", "A=12.0", ["294#01 01 01 e0 2e 00 00"]),  # there is room for two digits
    ("5 CR 6 CR", "A= 6.0", ["294#01 01 01 88 13 00 00", "294#01 01 02 70 17 00 00"]),
    ("5 CR 5 CR", "A= 5.0", ["294#01 01 01 88 13 00 00", "294#01 01 02 88 13 00 00"]),
    ("9 ESC", "A= 1.5", []),
    ("CR CR", "A= 1.5", []),
    ("CR MINUS CR", "A= 1.5", []),
    ("4 2 POINT", "A= 42.", []),
    ("4 F1 END UP 2", "A=  42", []),  # other keys do not type
    ("ESC DEL END F5", "A= 1.5", []),
]


@pytest.mark.parametrize(("keys", "shown", "edits"), EDITS)
def test_keys_change_the_value(bench: TerminalBench, keys: str, shown: str, edits: list[str]) -> None:
    sent = bench.press(keys)
    assert [frame for frame in sent if frame.startswith("294")] == edits
    assert bench.screen[0] == shown


def test_keys_go_to_the_card_also_while_they_type(bench: TerminalBench) -> None:
    assert [frame for frame in bench.press("4") if frame.startswith("194")] == ["194#08 00 00 00", "194#00 00 00 00"]


@pytest.mark.long
def test_values_from_the_card_do_not_disturb_what_is_typed(bench: TerminalBench) -> None:
    bench.press("4")
    bench.send("414#01 01 10 27 00 00")
    assert bench.screen[0] == "A=   4"
    bench.press("ESC")
    assert bench.screen[0] == "A=10.0"


@pytest.mark.parametrize("frame", ["314#01 01 01 00 00 02", "314#00 00 01 00 00 01", "314#01 01 01 01 00 05"])
def test_erasing_clearing_or_showing_again_ends_the_typing(bench: TerminalBench, frame: str) -> None:
    bench.press("4")
    bench.send(frame, "314#01 01 01 01 00 05", "414#01 01 dc 05 00 00")
    assert bench.screen[0] == "A= 1.5"
    assert [frame for frame in bench.press("CR") if frame.startswith("294")] == []


def test_terminal_that_starts_again_tells_of_no_edit(bench: TerminalBench) -> None:
    bench.press("4 CR")
    assert bench.send(PRE_OPERATIONAL, START) == ["194#00 00 00 00", "294#00 00 00 00 00 00 00"]


def test_only_fields_that_may_be_changed_have_the_cursor(bench: TerminalBench) -> None:
    assert bench.get("cursor") == "1 6"
    bench.send("314#01 01 01 01 00 04")  # with a value, but not editable
    assert bench.get("cursor") == ""
    assert [frame for frame in bench.press("4 CR") if frame.startswith("294")] == []


def test_message_without_a_field_can_not_be_changed() -> None:
    bench = TerminalBench()
    bench.store_message(1, "READY")
    bench.send("314#01 01 01 01 00 05")
    assert (bench.get("cursor"), bench.screen[0]) == ("", "READY")


# Place and height of a message `A=##.#`; place of the cursor.
CURSORS = [
    ("08 01 02", "8 11"),
    ("01 0c 01", "1 16"),  # cut off within its field
    ("01 0f 01", ""),  # before it
    ("08 01 03", "8 13"),
    ("00 01 01", ""),
]


@pytest.mark.parametrize(("place", "cursor"), CURSORS)
def test_cursor_is_at_the_last_cell_of_the_field_that_can_be_seen(place: str, cursor: str) -> None:
    bench = TerminalBench()
    bench.store_message(1, "A=##.#")
    bench.send(f"314#{place} 01 00 05")
    assert bench.get("cursor") == cursor
    edits = [frame for frame in bench.press("4 CR") if frame.startswith("294")]
    assert len(edits) == (cursor != "")  # an invisible value cannot be changed


# Keys and the cursor after each, from field to field in reading order, round and round.
MOVES = [("DOWN", "3 6"), ("DOWN", "1 6"), ("UP", "3 6"), ("LEFT", "1 6"), ("RIGHT", "3 6"), ("UP", "1 6")]


def test_arrows_move_the_cursor_from_field_to_field() -> None:
    with CellBench() as cell:
        cell.program(TWO_FIELDS)
        for key, cursor in MOVES:
            cell.press(key)
            assert cell.rig.get("tr", "cursor") == cursor


@pytest.mark.long
def test_edited_value_comes_back_to_the_variable_of_its_place() -> None:
    with CellBench() as cell:
        cell.program(TWO_FIELDS)
        cell.press("4 2 CR")
        assert (cell.card.V[1], cell.card.V[2]) == (42_000, 0)
        cell.press("DOWN 7 CR")
        assert (cell.card.V[1], cell.card.V[2]) == (42_000, 7_000)
        assert (cell.screen[0], cell.screen[2]) == ("A=42.0", " B=  7")


def test_value_that_the_program_sets_back_at_once_is_shown_again() -> None:
    with CellBench() as cell:
        cell.card.V[1] = 5_000
        cell.program(TWO_FIELDS)

        def refuse(number: int, raw: int) -> None:
            cell.card.V[number] = 5_000

        cell.on_edit = refuse
        cell.press("9 CR")
        assert cell.screen[0] == "A= 5.0"


def test_edit_is_sent_once_even_if_the_terminal_is_started_again() -> None:
    with CellBench() as cell:
        cell.program(TWO_FIELDS)
        cell.press("4 2 CR")
        cell.card.V[1] = 1_000
        cell.send(PRE_OPERATIONAL)
        cell.send(START)
        cell.after(2_000)
        assert cell.card.V[1] == 1_000
        cell.press("4 2 CR")
        assert cell.card.V[1] == 42_000


# Keys for a field of mode P (password 12), text of line 1, the edited values that were sent.
PASSWORDS = [
    ("CR 1", "A=   *", []),
    ("CR 1 2", "A=  **", []),
    ("CR 1 2 CR", "A=", []),
    ("CR 1 2 CR 7 CR", "A= 7.0", ["294#01 01 01 58 1b 00 00"]),
    ("1 2 CR 7 CR", "A= 7.0", ["294#01 01 01 58 1b 00 00"]),  # the first digit is part of the password
    ("CR 1 3 DEL 2 CR 7 CR", "A= 7.0", ["294#01 01 01 58 1b 00 00"]),
    ("CR 1 3 CR", "A= 1.5", []),  # the wrong one
    ("CR CR", "A= 1.5", []),
    ("CR 1 ESC", "A= 1.5", []),
    ("CR 1 2 CR 7 CR CR", "A=", ["294#01 01 01 58 1b 00 00"]),  # each value requires it again
]


@pytest.mark.parametrize(("keys", "shown", "edits"), PASSWORDS)
def test_mode_p_asks_for_the_password_first(bench: TerminalBench, keys: str, shown: str, edits: list[str]) -> None:
    bench.send("314#01 01 01 01 00 06", "414#01 01 dc 05 00 00")
    sent = bench.press(keys)
    assert [frame for frame in sent if frame.startswith("294")] == edits
    assert bench.screen[0] == shown
