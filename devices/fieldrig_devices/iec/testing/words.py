"""The words of test blocks: their parameters, and what each of them judges.

Both sets that are in use are known: ASSERT_EQ(actual, expected) and its kin of STruC++, which the docs use, and
ASSERT_EQUAL(expected, actual) and its kin of truST.
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.program import Operator

MESSAGE: Final = "message"
_ALIASES: Final = {
    "value": "actual",
    "bound": "expected",
    "delta": "tolerance",
    "in": "condition",
    "within": "time",
    "for": "time",
    "duration": "time",
    "count": "expected",
    "text": MESSAGE,
}
"""Other names of parameters, by which arguments may be given."""


@dataclass(frozen=True, slots=True)
class Word:
    """One statement of a test."""

    parameters: tuple[str, ...]
    """In the order of arguments without names, without `message`."""
    operator: Operator | None = None
    """The comparison of `actual` with `expected`; None for words that compare nothing."""
    has_message: bool = True

    def parameter(self, name: str) -> str | None:
        """Return the parameter that an argument of this name is for; None if there is none."""
        known = name.lower()
        known = known if known in self.parameters else _ALIASES.get(known, known)
        return known if known in self.parameters or (known == MESSAGE and self.has_message) else None


_PAIR: Final = ("actual", "expected")
_TURNED: Final = ("expected", "actual")

WORDS: Final = {
    "ASSERT": Word(("condition",)),
    "ASSERT_TRUE": Word(("condition",)),
    "ASSERT_FALSE": Word(("condition",)),
    "ASSERT_EQ": Word(_PAIR, Operator.EQ),
    "ASSERT_NEQ": Word(_PAIR, Operator.NE),
    "ASSERT_GT": Word(_PAIR, Operator.GT),
    "ASSERT_LT": Word(_PAIR, Operator.LT),
    "ASSERT_GE": Word(_PAIR, Operator.GE),
    "ASSERT_LE": Word(_PAIR, Operator.LE),
    "ASSERT_NEAR": Word((*_PAIR, "tolerance"), Operator.EQ),
    "ASSERT_EQUAL": Word(_TURNED, Operator.EQ),
    "ASSERT_NOT_EQUAL": Word(_TURNED, Operator.NE),
    "ASSERT_GREATER": Word(_PAIR, Operator.GT),
    "ASSERT_LESS": Word(_PAIR, Operator.LT),
    "ASSERT_GREATER_OR_EQUAL": Word(_PAIR, Operator.GE),
    "ASSERT_LESS_OR_EQUAL": Word(_PAIR, Operator.LE),
    "ASSERT_FAIL": Word(()),
    "ASSERT_WITHIN": Word(("condition", "time")),
    "ASSERT_NEVER": Word(("condition", "time")),
    "ASSERT_STAYS": Word(("condition", "time")),
    "ASSERT_UNTIL": Word(("condition", "end", "time")),
    "MOCK_VERIFY_CALLED": Word(("mock",)),
    "MOCK_VERIFY_CALL_COUNT": Word(("mock", "expected")),
    "MOCK": Word(("mock",), has_message=False),
    "MOCK_FUNCTION": Word(("mock", "returns"), has_message=False),
    "ADVANCE_TIME": Word(("time",), has_message=False),
    "RUN_FOR": Word(("time",), has_message=False),
    "FAULT": Word(("where", "fault"), has_message=False),
    "CLEAR_FAULTS": Word(("where",), has_message=False),
    "PRINT": Word(()),
}
CALLS: Final = "MOCK_CALLS"
"""The function that returns how often a mock was called."""
