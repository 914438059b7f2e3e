"""Numeric fields in messages: `#####.#` shows a value, and determines what an operator may type.

Source: manual 5.12 (MSG); digest chapter 16.  A field is as wide as its pattern.  The number is right-aligned, a minus
sign takes one place, and a number that does not fit is shown as `*`.  The longest pattern is `#####.###`; the rest of a
longer one is text.
"""

import re
from dataclasses import dataclass
from typing import Final, Literal

Decimals = Literal["cut", "rounded"]

_PATTERN: Final = re.compile(r"#{1,5}(?:\.#{1,3})?")
_DECIMALS: Final = 3  # decimals of a raw integer, value x 1000


@dataclass(frozen=True, slots=True)
class Pattern:
    """A field in a message: where it starts, how wide it is, and how many decimals it has."""

    start: int
    width: int
    decimals: int

    def show(self, raw: int, decimals: Decimals = "cut") -> str:
        """Format a value in `width` characters.  Excess decimals are cut off, or rounded with halves away from 0."""
        divisor = 10 ** (_DECIMALS - self.decimals)
        units = (abs(raw) + (divisor // 2 if decimals == "rounded" else 0)) // divisor
        digits = f"{units:0{self.decimals + 1}}"
        text = ("-" if raw < 0 < units else "") + _with_point(digits, self.decimals)
        return text.rjust(self.width) if len(text) <= self.width else "*" * self.width

    def put_into(self, message: str, inside: str) -> str:
        """The message with `inside` instead of the pattern."""
        return message[: self.start] + inside + message[self.start + self.width :]

    def parse(self, typed: str) -> int | None:
        """Raw value of the text that was typed, or None if it is not a number yet."""
        whole, _, fraction = typed.lstrip("-").partition(".")
        if not whole + fraction:
            return None
        raw = int((whole or "0") + fraction.ljust(_DECIMALS, "0"))
        return -raw if typed.startswith("-") else raw

    def typed(self, before: str, key: str) -> str:
        """The typed text after a digit, POINT, MINUS or DEL; unchanged if the key is not possible."""
        if key == "DEL":
            return before[:-1]
        if key == "MINUS":
            after = before[1:] if before.startswith("-") else "-" + before
        else:
            after = before + ("." if key == "POINT" else key)
        return after if self._takes(after) else before

    def _takes(self, typed: str) -> bool:
        _, point, fraction = typed.lstrip("-").partition(".")
        has_room = len(typed) <= self.width and len(fraction) <= self.decimals
        if not has_room or "." in fraction or (point and not self.decimals):
            return False
        raw = self.parse(typed)
        return raw is None or "*" not in self.show(raw)


def find(text: str) -> Pattern | None:
    """The first field in a message, or None."""
    match = _PATTERN.search(text)
    if match is None:
        return None
    return Pattern(match.start(), len(match[0]), len(match[0].partition(".")[2]))


def _with_point(digits: str, decimals: int) -> str:
    return f"{digits[:-decimals]}.{digits[-decimals:]}" if decimals else digits
