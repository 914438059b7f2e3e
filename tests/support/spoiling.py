"""Corrupted inputs: bytes, lines of text, and trees of JSON, each made from a valid input."""

import copy
import json
import random
import re
from typing import Any, Final

PIECES: Final = [
    b"[" * 2000, b"{", b"[[1,2]]", b'[{"a":1}]', b"null", b"NaN", b"1e999", b"9" * 30, b'"\\ud800"', b"\xff" * 9,
    b"\x00" * 9, b"\r", b"\n", b" ", b"<", b">", b"-1", b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff",
]  # fmt: skip
WORDS: Final = [
    "",
    "0",
    "-1",
    "1",
    "65536",
    "4294967296",
    "1e999",
    "1e400",
    ".nan",
    "-.inf",
    "9" * 50,
    "9" * 5000,
    "0x",
    "0xFFFFFFFFFFFF",
    "0x1F800",
    "0777",
    "null",
    "true",
    "[]",
    "{}",
    "[1, 2]",
    "{a: 1}",
    "[[[]]]",
    "{1: 2}",
    "text",
    "\u00e4\u20ac",
    "x" * 300,
    "x" * 5000,
    "*a",
    "&a b",
    "!!set {a}",
    "!x y",
    '"\\ud800"',
    '"\\0"',
    "\x00",
    "..",
    "/",
    ".",
    "a:b",
    "a.b:C",
    "json:dumps",
    "$NODEID",
    "$NODEID+0x7FFFFFFF",
    "NaN",
    "00 01",
    "0102",
    "rw",
    "const",
    "2.5",
    "-0.0",
    "on",
    "12:30",
    "2026-01-01",
    "1 ; x",
]
VALUES: Final[list[Any]] = [
    None, True, False, 0, -1, 1, 255, 65536, 2**31, -(2**31), 2**63, 2**64, 10**30, 0.5, -0.0, 1e308, "", "0", "x",
    "ff", "ffffffffffffffff", "\u00e4", "\0", "x" * 300, [], {}, [1, 2], [[]], {"a": 1}, [None] * 40,
]  # fmt: skip


def spoilt(chance: random.Random, seeds: list[bytes]) -> bytes:
    """A seed, or two of them, with some bytes otherwise; some inputs are noise from end to end."""
    if chance.random() < 0.05:
        return chance.randbytes(chance.randrange(64))
    data = bytearray(chance.choice(seeds))
    for _ in range(chance.choice((0, 1, 1, 1, 2, 3, 8))):
        place = chance.randrange(len(data) + 1)
        match chance.randrange(7):
            case 0 if data:
                data[place % len(data)] ^= 1 << chance.randrange(8)
            case 1 if data:
                data[place % len(data)] = chance.randrange(256)
            case 2:
                del data[place : place + chance.randrange(1, 9)]
            case 3:
                data[place:place] = chance.randbytes(chance.randrange(1, 9))
            case 4:
                data[place:place] = chance.choice(PIECES)
            case 5:
                data[place:place] = chance.choice(seeds)
            case _:
                del data[place:]
    return bytes(data)


def spoilt_file(chance: random.Random, seeds: list[bytes]) -> bytes:
    """Return a damaged version of a file of `key: value` or `key=value` lines: other values, missing or moved lines."""
    if chance.random() < 0.15:
        return spoilt(chance, seeds)
    lines = chance.choice(seeds).decode().splitlines()
    for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
        place = chance.randrange(len(lines)) if lines else 0
        line = lines[place] if lines else ""
        match chance.randrange(8):
            case 0:
                del lines[place : place + chance.choice((1, 1, 1, 5, 50))]
            case 1:
                lines.insert(chance.randrange(len(lines) + 1), line)
            case 2:
                lines.insert(place, " " * chance.randrange(6) + chance.choice(WORDS))
            case _ if lines:
                lines[place] = _with_another_value(chance, line)
            case _:
                pass
    return "\n".join(lines).encode()


FIELD: Final = re.compile(rb"[0-9A-Fa-f.]+|[A-Za-z]+|.", re.DOTALL)
NUMBERS: Final = [
    b"0", b"-1", b"65", b"256", b"9" * 19, b"9" * 40, b"1e999", b"nan", b"FFFFFFFFF", b"80000000", b"A", b"0" * 70, b"",
    b"2099-12-31", b"1969-12-31", b"0000-00-00", b"12/31/9999", b"25:61:61.000", b"\xb9", b"AB" * 40,
]  # fmt: skip


def spoilt_lines(chance: random.Random, seeds: list[bytes]) -> bytes:
    """Return a damaged log of text: other fields, half, repeated and missing lines."""
    if chance.random() < 0.15:
        return spoilt(chance, seeds)
    lines = chance.choice(seeds).split(b"\n")
    for _ in range(chance.choice((1, 1, 2, 3, 6))):
        place = chance.randrange(len(lines))
        line = lines[place]
        fields = FIELD.findall(line) or [b""]
        match chance.randrange(8):
            case 0:
                lines[place] = line[: chance.randrange(len(line) + 1)]
            case 1:
                lines[place] = line * chance.choice((2, 50))
            case 2:
                del fields[chance.randrange(len(fields))]
                lines[place] = b"".join(fields)
            case 3:
                lines.insert(place, chance.choice(lines))
            case _:
                fields[chance.randrange(len(fields))] = chance.choice((*NUMBERS, *fields))
                lines[place] = b"".join(fields)
    return b"\n".join(lines)


def _with_another_value(chance: random.Random, line: str) -> str:
    """Return the line with another value; in YAML it may be one of several in braces."""
    starts = [place for place, letter in enumerate(line, 1) if letter in ":=[,{"]
    if not starts:
        return chance.choice(WORDS)
    start = chance.choice(starts)
    ends = [place for place in range(start, len(line)) if line[place] in ",]}"] or [len(line)]
    space = "" if line[start - 1] == "=" else " "
    return line[:start] + space + chance.choice(WORDS) + line[chance.choice((ends[0], ends[0], len(line))) :]


def spoilt_json(chance: random.Random, seeds: list[bytes]) -> bytes:
    """Valid JSON with some values changed; now and then corrupted bytes, which are hardly ever valid JSON."""
    if chance.random() < 0.15:
        return spoilt(chance, seeds)
    tree: Any = {"": json.loads(chance.choice(seeds))}
    for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
        inner, key = chance.choice(_places(tree))
        match chance.randrange(6):
            case 0:
                del inner[key]
            case 1 if isinstance(inner, dict):
                inner[chance.choice(("", "x", "1", "-1", "FFFF:FF", "4294967296"))] = inner.pop(key)
            case 2 if isinstance(inner[key], int):
                inner[key] += chance.choice((1, -1, 256, 2**16, -(2**31)))
            case 3 if isinstance(inner[key], list):
                inner[key] = copy.deepcopy(inner[key] * 2)
            case _:
                inner[key] = copy.deepcopy(chance.choice(VALUES))
        if not tree:
            break
    return json.dumps(tree.get("", None)).encode()


def _places(tree: Any) -> list[tuple[Any, Any]]:
    """Yield every container within `tree` with each of its keys."""
    found: list[tuple[Any, Any]] = []
    waiting = [tree]
    while waiting:
        inner = waiting.pop()
        keys = list(inner) if isinstance(inner, dict) else list(range(len(inner)))
        found += [(inner, key) for key in keys]
        waiting += [inner[key] for key in keys if isinstance(inner[key], dict | list)]
    return found
