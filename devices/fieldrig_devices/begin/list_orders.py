"""The order of words and bytes that a list of registers says: in a type such as `float (CDAB)`, or in a column."""

import re
from collections.abc import Mapping
from typing import Any, Final

ORDERS: Final[Mapping[str, Mapping[str, Any]]] = {
    "abcd": {},
    "cdab": {"word_order": "little"},
    "badc": {"byte_order": "little"},
    "dcba": {"word_order": "little", "byte_order": "little"},
}
ORDER_WORDS: Final = (
    (re.compile(r"\b(?:byte)[ _-]?swap", re.IGNORECASE), "badc"),
    (
        re.compile(
            r"(?:lsw|low(?:er)? word|least significant word)[ _-]?(?:first)?|word[ _-]?swap|\bswap", re.IGNORECASE
        ),
        "cdab",
    ),
    (re.compile(r"little|\blsb|\ble\b|inver[st]|reverse", re.IGNORECASE), "dcba"),
)
"""Words for an order, and what they mean; lists do not agree on the last ones."""
UNSURE: Final = "dcba"
_IN_DIGITS: Final = {"1234": "abcd", "3412": "cdab", "2143": "badc", "4321": "dcba"}
_LITTLE: Final = re.compile(r"little|low|lsw|ls[br]|swap|revers|yes|true|\b1\b", re.IGNORECASE)


def order_of(row: Mapping[str, str]) -> str | None:
    """Return the order that a row says, as letters; None if it says none."""
    if _LITTLE.search(row.get("word_order", "")):
        return "cdab"
    return _order_in(row.get("order", "")) or _order_in(row.get("type", ""))


def is_unsure(row: Mapping[str, str]) -> bool:
    """Return whether the order of a row is one that lists do not agree on."""
    text = " ".join(row.get(column, "") for column in ("order", "type")).casefold()
    return order_of(row) == UNSURE and UNSURE not in text and "4321" not in text


def _order_in(text: str) -> str | None:
    words = re.findall(r"[a-d]{4}|[1-4]{4}", re.sub(r"(?<=\w)[ -](?=\w\b)", "", text.casefold()))
    letters = next((order for word in words if (order := _IN_DIGITS.get(word, word)) in ORDERS), None)
    return letters or next((order for pattern, order in ORDER_WORDS if pattern.search(text)), None)
