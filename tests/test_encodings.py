"""Every text file of the product is read and written with a stated encoding: that of Windows is a code page.

ruff (PLW1514) finds calls of `open` and of what it knows to be a path; this finds those of any object.
"""

import ast
import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest

PACKAGES: Final = ("fieldrig", "fieldrig_bus", "fieldrig_devices", "fieldrig_page")
POSITION: Final = {"read_text": 0, "write_text": 1}
"""The place of the encoding among the arguments."""
OPENING: Final = {"open": 0, "open_file": 1, "fdopen": 1}
"""The place of the mode among the arguments of a call of an object's method, or of a function."""
CALL: Final = re.compile(r"\b(?:read_text|write_text|open_file|fdopen)\(|\bopen\([^)\n]*['\"]")
"""Files without this are not parsed."""
TEXT: Final = {"r", "w", "a", "x", "r+", "w+", "a+", "x+", "rt", "wt", "at", "xt"}


def without_encoding(text: str) -> Iterator[int]:
    """Yield the lines of the calls that leave the encoding to the system."""
    if CALL.search(text) is None:
        return
    for call in ast.walk(ast.parse(text)):
        if isinstance(call, ast.Call) and _leaves_it_open(call):
            yield call.lineno


def _leaves_it_open(call: ast.Call) -> bool:
    name = getattr(call.func, "attr", getattr(call.func, "id", ""))
    if any(keyword.arg in ("encoding", None) for keyword in call.keywords):
        return False
    if name in POSITION:
        return len(call.args) <= POSITION[name]
    if name not in OPENING:
        return False
    place = 1 if isinstance(call.func, ast.Name) else OPENING[name]
    modes = [keyword.value for keyword in call.keywords if keyword.arg == "mode"] or call.args[place : place + 1]
    return any(isinstance(mode, ast.Constant) and mode.value in TEXT for mode in modes)


@pytest.mark.long
@pytest.mark.parametrize("package", PACKAGES)
def test_every_text_file_has_a_stated_encoding(package: str) -> None:
    folder = Path(importlib.import_module(package).__path__[0])
    found = [
        f"{path.relative_to(folder)}:{line}"
        for path in sorted(folder.rglob("*.py"))
        for line in without_encoding(path.read_text(encoding="utf-8"))
    ]
    assert found == []


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("x.read_text()", 1),
        ("x.read_text('utf-8')", 0),
        ("x.write_text(y)", 1),
        ("x.write_text(y, encoding='utf-8')", 0),
        ("x.open('w')", 1),
        ("x.open(mode='a')", 1),
        ("x.open('wb')", 0),
        ("open_file(x, 'a')", 1),
        ("os.fdopen(x, 'w')", 1),
        ("open(x, 'r', **more)", 0),
        ("port.open()", 0),
    ],
)
def test_a_call_that_leaves_the_encoding_open_is_found(text: str, count: int) -> None:
    assert len([*without_encoding(text)]) == count
