"""The body of an AT command line, after `AT`, as its commands (ITU-T V.250, 5.2 to 5.4).

Letters may be small or capital, and spaces are ignored outside of a string in quotes, as real modems do.  Commands up
to a mistake are carried out, so the mistake is the last item.
"""

import re
from typing import Final, NamedTuple


class Basic(NamedTuple):
    name: str
    value: int


class Register(NamedTuple):
    """`Sn=value`, or `Sn?`, or `Sn` alone, each with the register of before if `number` is None."""

    number: int | None
    value: int | None
    is_read: bool


class Dial(NamedTuple):
    """D with its dial string; with `stays`, the modem returns to the command state after it."""

    string: str
    stays: bool


class Extended(NamedTuple):
    name: str
    operation: str
    """"", "=", "?" or "=?"."""
    fields: tuple[str, ...] = ()


class StoreNumber(NamedTuple):
    """`&Zn=string`: a telephone number to keep."""

    place: int
    string: str


class Mistake(NamedTuple):
    """No command, from here on."""

    text: str


Item = Basic | Register | Dial | Extended | StoreNumber | Mistake
LONGEST_NUMBER: Final = 5
"""The most digits of the number behind a basic command; a command with a longer one is refused."""

_BASIC = re.compile(rf"([A-CE-RT-Z]|[&%\\*#-][A-Z])(\d{{0,{LONGEST_NUMBER}}})(?!\d)")
_REGISTER = re.compile(r"S(\d{0,3})(?!\d)(?:(\?)|=(\d{0,5}))?")
_SELECTED = re.compile(r"(\?)|=(\d{0,5})")
_NUMBER = re.compile(r"&Z(\d?)=(.*)")
_EXTENDED = re.compile(r'(\+[A-Z][A-Z0-9!%\-./:_]*)(=\?|\?|=((?:"[^"]*"|[^;"])*))?(?:;|$)')


def parse(body: str) -> list[Item]:
    text, items, at = _tidied(body), [], 0
    while at < len(text):
        if text[at] == ";":  # some drivers end every command so
            at += 1
            continue
        item, at = _item(text, at)
        items.append(item)
        if isinstance(item, Mistake):
            break
    return items


def _tidied(body: str) -> str:
    """Return the line in capitals without spaces; strings in quotes stay as they are."""
    parts = body.split('"')
    return '"'.join(part if index % 2 else part.replace(" ", "").upper() for index, part in enumerate(parts))


def _item(text: str, at: int) -> tuple[Item, int]:
    if text[at] == "D":
        end = text.find(";", at)
        return (Dial(text[at + 1 :], False), len(text)) if end < 0 else (Dial(text[at + 1 : end], True), end + 1)
    if match := _NUMBER.match(text, at):
        return StoreNumber(int(match[1] or 0), match[2]), len(text)
    if match := _EXTENDED.match(text, at):
        operation = match[2] or ""
        if operation in ("", "?", "=?"):
            return Extended(match[1], operation), match.end()
        return Extended(match[1], "=", tuple(match[3].split(","))), match.end()
    if match := _REGISTER.match(text, at):
        return _register(match[1], match[2], match[3]), match.end()
    if match := _SELECTED.match(text, at):
        return _register("", match[1], match[2]), match.end()
    if match := _BASIC.match(text, at):
        return Basic(match[1], int(match[2] or 0)), match.end()
    return Mistake(text[at:]), len(text)


def _register(number: str, read: str | None, value: str | None) -> Register:
    return Register(int(number) if number else None, None if value is None else int(value or 0), read is not None)
