"""The string functions of Standard.lib, with every edge of their numbers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.iec.library.intrinsics import evaluate
from fieldrig_devices.iec.types import Value

CASES: list[tuple[str, list[Value], Value]] = [
    ("LEN", ["SUSI"], 4),
    ("LEN", [""], 0),
    ("LEFT", ["SUSI", 3], "SUS"),
    ("LEFT", ["SUSI", 9], "SUSI"),
    ("LEFT", ["SUSI", 0], ""),
    ("LEFT", ["SUSI", -1], ""),
    ("RIGHT", ["SUSI", 3], "USI"),
    ("RIGHT", ["SUSI", 9], "SUSI"),
    ("RIGHT", ["SUSI", 0], ""),
    ("RIGHT", ["SUSI", -2], ""),
    ("MID", ["SUSI", 2, 2], "US"),
    ("MID", ["SUSI", 9, 3], "SI"),
    ("MID", ["SUSI", 2, 5], ""),
    ("MID", ["SUSI", 2, 0], ""),
    ("MID", ["SUSI", -2, 1], ""),
    ("CONCAT", ["SUSI", "WILLI"], "SUSIWILLI"),
    ("CONCAT", ["A", "B", "C"], "ABC"),
    ("CONCAT", ["A" * 200, "B" * 200], "A" * 200 + "B" * 55),
    ("INSERT", ["SUSI", "XY", 2], "SUXYSI"),
    ("INSERT", ["SUSI", "XY", 0], "XYSUSI"),
    ("INSERT", ["SUSI", "XY", -3], "XYSUSI"),
    ("INSERT", ["SUSI", "XY", 99], "SUSIXY"),
    ("DELETE", ["SUXYSI", 2, 3], "SUSI"),
    ("DELETE", ["SUSI", 9, 2], "S"),
    ("DELETE", ["SUSI", 2, 0], "USI"),
    ("DELETE", ["SUSI", 1, 0], "SUSI"),
    ("DELETE", ["SUSI", 0, 0], "SUSI"),
    ("DELETE", ["SUSI", 9, 0], ""),
    ("DELETE", ["SUSI", 2, -1], "SUSI"),
    ("DELETE", ["SUSI", 2, 5], "SUSI"),
    ("DELETE", ["SUSI", -1, 2], "SUSI"),
    ("REPLACE", ["SUXYSI", "K", 2, 2], "SKYSI"),
    ("REPLACE", ["SUSI", "K", 9, 4], "SUSK"),
    ("REPLACE", ["SUSI", "K", 1, 5], "SUSI"),
    ("REPLACE", ["SUSI", "K", 0, 1], "KSUSI"),
    ("FIND", ["SUXYSI", "XY"], 3),
    ("FIND", ["SUSI", "S"], 1),
    ("FIND", ["SUSI", "X"], 0),
    ("FIND", ["SUSI", ""], 0),
]


@pytest.mark.parametrize(("name", "arguments", "result"), CASES)
def test_string_functions(name: str, arguments: list[Value], result: Value) -> None:
    assert evaluate(name, arguments) == result


NUMBERS = st.integers(-32_768, 32_767) | st.integers(-2, 12)
TEXTS = st.text(st.characters(max_codepoint=255), max_size=255)


@pytest.mark.long
@given(TEXTS, TEXTS, NUMBERS, NUMBERS)
def test_string_functions_never_raise_and_never_exceed_255_characters(
    text: str, part: str, size: int, place: int
) -> None:
    results = [
        evaluate("LEFT", [text, size]),
        evaluate("RIGHT", [text, size]),
        evaluate("MID", [text, size, place]),
        evaluate("CONCAT", [text, part]),
        evaluate("INSERT", [text, part, place]),
        evaluate("DELETE", [text, size, place]),
        evaluate("REPLACE", [text, part, size, place]),
    ]
    assert all(isinstance(result, str) and len(result) <= 255 for result in results)
    assert evaluate("FIND", [text, part]) in range(256)


@given(TEXTS, st.integers(0, 255))
def test_left_and_right_make_up_the_whole(text: str, size: int) -> None:
    rest = len(text) - min(size, len(text))
    assert str(evaluate("LEFT", [text, size])) + str(evaluate("RIGHT", [text, rest])) == text


@pytest.mark.long
@given(
    TEXTS.filter(lambda text: len(text) <= 100), TEXTS.filter(lambda text: 0 < len(text) <= 100), st.integers(0, 100)
)
def test_an_inserted_text_is_deleted_again(text: str, part: str, place: int) -> None:
    behind = min(place, len(text))
    inserted = evaluate("INSERT", [text, part, behind])
    assert evaluate("MID", [inserted, len(part), behind + 1]) == part
    assert evaluate("DELETE", [inserted, len(part), behind + 1]) == text
