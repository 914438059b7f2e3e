"""Forms of other languages, and what they are in that of the ARP.

A line that cannot be read is looked at once more: if one of these habits is where the reader stopped, its message names
the right form instead of the sign that was not expected.
"""

import re
from collections.abc import Callable
from typing import Final, NamedTuple

from fieldrig_devices.languages.mistakes import LineError

_Right = Callable[[re.Match[str]], str]


class _Habit(NamedTuple):
    pattern: re.Pattern[str]
    right: _Right
    """Returns the right form.  The group `got`, or the whole match, is what is wrong."""


def _is(pattern: str, right: str | _Right) -> _Habit:
    known = (lambda _: right) if isinstance(right, str) else right
    return _Habit(re.compile(pattern, re.IGNORECASE | re.ASCII), known)


def _decimal(match: re.Match[str]) -> str:
    base, digits = match["base"], match["digits"]
    return str(int(digits, {"2#": 2, "0b": 2, "8#": 8}[base.lower()]))


_INSTRUCTION: Final = r"^\s*(?:\w+\s*:)?\s*"
_SIGNS: Final = {"AND": "&", "OR": "|", "XOR": "^", "NOT": "!", "MOD": "%"}
_RELATIONS: Final = {"!=": "<>", "><": "<>", "=>": ">=", "=<": "<="}
_FUNCTIONS: Final = {"SIN": "SEN", "SQRT": "SQR"}

_HABITS: Final = (
    _is(_INSTRUCTION + r"(?P<got>REM\b|//|/\*|\(\*|'|\{|--\s)", "a comment, which begins with ;"),
    _is(_INSTRUCTION + r"(?P<got>LET)\b", "the assignment alone, as in V1 == 5"),
    _is(_INSTRUCTION + r"(?P<got>\+\+|--)(?P<name>[A-Z]\w*)", lambda found: f"{found['name']} {found['got'][0]}= 1"),
    _is(r"(?P<name>[A-Z]\w*)(?P<got>\+\+|--)", lambda found: f"{found['name']} {found['got'][0]}= 1"),
    _is(_INSTRUCTION + r"[A-Z]\w*(?:\[[^]]*\])?\s*(?P<got>:=|<-|=:|=>)", "=="),
    _is(_INSTRUCTION + r"(?P<got>GOSUB)\b", "CALL"),
    _is(_INSTRUCTION + r"(?P<got>DELAY|DWELL|SLEEP|PAUSE)\b", "WAIT"),
    _is(
        _INSTRUCTION + r"(?P<got>END_?IF|ELSE\w*|ELSIF)\b",
        "another way: an IF is one line, IF V1 = 5, LABEL, and has no end",
    ),
    _is(
        _INSTRUCTION + r"(?P<got>FOR|NEXT|WHILE|WEND|DO|LOOP|REPEAT|UNTIL|SWITCH|SELECT|CASE)\b",
        "a label, and IF V1 < 5, LABEL to go back to it",
    ),
    _is(_INSTRUCTION + r"(?P<got>RETURN|RET|EXIT|HALT)\b", "GOTO: a routine ends at its END"),
    _is(r"\bIF\b[^,]*(?P<got>\bTHEN)\b", "a comma, and an instruction or a label"),
    _is(r"\bIF\b[^,]*[=<>][^,]*\b(?P<got>AND|OR)\b", "one comparison, and another IF behind the comma"),
    _is(r"\bIF\s+(?P<got>\([^,]*\))\s*,", "the comparison without parentheses"),
    _is(
        r"\bIF\s+(?P<got>(?P<no>NOT\s+|!|/)?(?P<name>[A-Z]\w*))\s*,",
        lambda found: f"{found['name']} {'=' if found['no'] else '<>'} LO",
    ),
    _is(r"\bIF\b[^,]*?(?P<got>!=|><|=>|=<)", lambda found: _RELATIONS[found["got"]]),
    _is(r"(?<!\w)(?P<got>(?:0x|16#|#|\$|&H)(?P<digits>[0-9A-F]{1,8}))\b", lambda found: f"H{found['digits'].upper()}"),
    _is(r"\b(?P<got>(?P<digits>[0-9][0-9A-F]{0,7})H)\b", lambda found: f"H{found['digits'].upper()}"),
    _is(r"\b(?P<got>(?P<base>2#|0b)(?P<digits>[01]+))\b", _decimal),
    _is(r"\b(?P<got>(?P<base>8#)(?P<digits>[0-7]+))\b", _decimal),
    _is(r"\b(?P<got>[0-9]+(?:\.[0-9]*)?E[-+]?[0-9]+)\b", "a number without an exponent"),
    _is(r"==\s*(?P<got>(?P<whole>[0-9]+),(?P<part>[0-9]{1,3}))\s*$", lambda found: f"{found['whole']}.{found['part']}"),
    _is(r"\b(?P<got>(?P<number>[0-9]+)(?:ms|s|sec))\b", lambda found: f"{found['number']}, a time without its unit"),
    _is(r"(?P<got>'(?P<text>[^']*)')", lambda found: f'"{found["text"]}"'),
    _is(r"\b(?P<got>SIN|SQRT)\s*\(", lambda found: _FUNCTIONS[found["got"].upper()]),
    _is(r"\b(?P<got>V\s*\((?P<index>[^)]*)\))", lambda found: f"V[{found['index']}]"),
    _is(r"\b(?P<got>AND|OR|XOR|NOT|MOD)\b", lambda found: _SIGNS[found["got"].upper()]),
    _is(_INSTRUCTION + r"(?P<got>(?P<right>(?:SET|RES)\s+\w+)\s*=+\s*\w+)", lambda found: found["right"]),
    _is(r"(?P<got>[←–−])", lambda found: "==" if found["got"] == "←" else "-"),
)  # fmt: skip


def in_words_of_the_language(line: str, wrong: LineError) -> LineError:
    """Return the message about a habit that is at the place of a mistake, or the mistake itself."""
    code = line.partition(";")[0]
    for pattern, right in _HABITS:
        for found in pattern.finditer(code):
            if found.start() < wrong.column <= found.end() + 2:
                return LineError(found.start("got") + 1, f"got {found['got']}", right(found))
    return wrong
