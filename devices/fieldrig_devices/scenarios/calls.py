"""Names of messages and diagnoses in expressions: `message(can0, id=0x181)`, `diagnosis(max4 8130)`.

A blank stands between the parts as a comma does, which would need quotes in YAML's {...}.

Such a name is a place, as `tank/level` is one; `places` finds them in a rig, and `live_places` in one in real time.
"""

import re
from collections.abc import Mapping
from typing import Final, NamedTuple

KINDS: Final = ("message", "count", "since", "diagnosis")
"""`message`: true at each instant at which a message arrives; `count`: how many have; `since`: the seconds since the
last one; `diagnosis`: true while a device shows this number."""
KEYS: Final = ("id", "node", "service", "code", "unit", "register", "data", "sender", "text")
"""The keys that a message may be chosen by."""
_NAME: Final = re.compile(r"(message|count|since|diagnosis)\((.*)\)", re.DOTALL)
_PART: Final = re.compile(r"""\s*(?:([^\s=,'"]+)\s*=\s*)?("[^"]*"|'[^']*'|[^\s=,'"]+)\s*(?:,|\s|$)""")


class Call(NamedTuple):
    """The parts of such a name."""

    kind: str
    target: str
    """The bus, or the device."""
    words: Mapping[str, str]
    """The words that choose a message, by key."""
    number: str = ""
    """The diagnosis."""

    def __str__(self) -> str:
        parts = [self.number] if self.number else [f"{key}={_quoted(value)}" for key, value in self.words.items()]
        return f"{self.kind}({', '.join([self.target, *parts])})"


def call_of(name: str) -> Call | None:
    """Return the parts of a name; None for one of another sort.  ValueError, with what was expected, if it is wrong."""
    found = _NAME.fullmatch(name)
    if found is None:
        return None
    kind, (target, *others) = found[1], _parts(found[1], found[2])
    if target[0]:
        raise ValueError(f"{kind} begins with {target[0]}=\nexpected {_FORMS[kind]}")
    if kind == "diagnosis":
        if len(others) != 1 or others[0][0]:
            raise ValueError(f"diagnosis has {len(others) + 1} values\nexpected {_FORMS[kind]}")
        return Call(kind, target[1], {}, others[0][1])
    words: dict[str, str] = {}
    for key, value in others:
        if key not in KEYS:
            raise ValueError(f"{kind} has {key or value!r}\nexpected one of {', '.join(f'{one}=' for one in KEYS)}")
        if key in words:
            raise ValueError(f"{kind} has {key}= twice\nexpected it once")
        words[key] = value
    return Call(kind, target[1], words)


def is_of_an_arrival(name: str) -> bool:
    """Return whether a place is true as a message arrives: it follows the places that count the same message."""
    return name.startswith("message(")


_FORMS: Final = {
    "message": "message(can0, id=0x181)",
    "count": "count(can0, id=0x181)",
    "since": "since(can0, node=io, service=heartbeat)",
    "diagnosis": "diagnosis(max4, 8130)",
}


def _parts(kind: str, text: str) -> list[tuple[str, str]]:
    """Return keys and values; the key is empty where there is none."""
    parts, at = list[tuple[str, str]](), 0
    while at < len(text) or not parts:
        found = _PART.match(text, at)
        if found is None:
            got = text[at:].strip()[:20]
            raise ValueError(f"{kind} has {got!r}\nexpected {_FORMS[kind]}")
        value = found[2]
        parts.append((found[1] or "", value[1:-1] if value[0] in "'\"" else value))
        at = found.end()
    return parts


def _quoted(text: str) -> str:
    """Return a text with quotes if it needs them."""
    if text and not re.search(r"""[\s=,'"()]""", text):
        return text
    return f"'{text}'" if '"' in text else f'"{text}"'
