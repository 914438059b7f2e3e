"""The trace of the debugger: its words, the wait for its samples, and the table or CSV that it becomes."""

import csv
import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final
from uuid import uuid4

from fieldrig_devices.languages.debugging.adapter import Ask
from fieldrig_devices.languages.debugging.prompt import NotStoppedError
from fieldrig_devices.languages.debugging.texts import text_of

DEPTH: Final = 20
_NUMBERS: Final = ("every", "depth", "before")


@dataclass(slots=True)
class Wanted:
    """A recording as the words of `trace` describe it."""

    names: list[str] = field(default_factory=list)
    numbers: dict[str, int] = field(default_factory=dict)
    trigger: dict[str, Any] | None = None
    own: str = field(default_factory=lambda: uuid4().hex)
    """The name of this trace, as others may record at the same time."""
    file: str | None = None
    """The file for CSV; an empty text for CSV on the screen, None for a table."""

    def question(self) -> dict[str, Any]:
        trigger = None if self.trigger is None else {**self.trigger, "before": self.numbers.get("before", 0)}
        return {
            "command": "record",
            "trace": self.own,
            "names": self.names,
            "every": self.numbers.get("every", 1),
            "depth": self.depth,
            "trigger": trigger,
        }

    @property
    def depth(self) -> int:
        return self.numbers.get("depth", DEPTH)


def wanted_of(words: Sequence[str]) -> Wanted:
    """Read `NAME... [every N] [depth N] [trigger NAME [rising|falling|any] [LEVEL]] [before N] [csv [FILE]]`."""
    wanted, rest = Wanted(), list(words)
    while rest:
        word = rest.pop(0)
        if word in _NUMBERS:
            wanted.numbers[word] = _number(word, rest)
        elif word == "trigger":
            wanted.trigger = _trigger(rest)
        elif word == "csv":
            wanted.file = rest.pop(0) if rest and rest[0] not in (*_NUMBERS, "trigger") else ""
        else:
            wanted.names.append(word)
    if not wanted.names:
        raise ValueError("nothing to record\nexpected names, such as `trace Main.count depth 20`")
    if "before" in wanted.numbers and wanted.trigger is None:
        raise ValueError("`before` needs a trigger\nexpected `trigger NAME rising LEVEL before N`")
    return wanted


def _number(word: str, rest: list[str]) -> int:
    if not rest or not rest[0].isdecimal() or len(rest[0]) > 9:
        raise ValueError(f"expected a number after {word}, got {rest[0] if rest else 'nothing'!r}")
    return int(rest.pop(0))


def _trigger(rest: list[str]) -> dict[str, Any]:
    if not rest:
        raise ValueError("expected a name after trigger, such as `trigger Main.speed rising 2.5`")
    trigger: dict[str, Any] = {"name": rest.pop(0)}
    if rest and rest[0] in ("rising", "falling", "any"):
        trigger["edge"] = rest.pop(0)
    if rest and (level := _level(rest[0])) is not None:
        rest.pop(0)
        trigger["level"] = level
    return trigger


def _level(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def trace(ask: Ask, words: Sequence[str], moments: Callable[[], Iterator[object]]) -> list[str]:
    """Record values, and return them as lines; Ctrl-C ends a trace with the samples that are there.

    NotStoppedError if the samples do not come in the time of `moments`.
    """
    wanted = wanted_of(words)
    ask(wanted.question())
    try:
        answer = _recorded(ask, wanted, moments)
    finally:
        ask({"command": "record", "trace": wanted.own, "names": []})
    rows = _rows(answer)
    lost = [f"missing for lack of time on the host: {_samples(answer['lost'])}"] if answer["lost"] else []
    if wanted.file is None:
        return [*_table(("time/s", *wanted.names), rows), *lost]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([("time/s", *wanted.names), *rows])
    if not wanted.file:
        return text.getvalue().splitlines()
    try:
        Path(wanted.file).write_text(text.getvalue(), encoding="utf-8")
    except OSError as cause:
        raise ValueError(f"{wanted.file} cannot be written: {cause.strerror or cause}") from cause
    return [f"{wanted.file}: {_samples(len(rows))}", *lost]


def _samples(count: int) -> str:
    return "1 sample" if count == 1 else f"{count} samples"


def _recorded(ask: Ask, wanted: Wanted, moments: Callable[[], Iterator[object]]) -> dict[str, Any]:
    answer: dict[str, Any] = {"samples": []}
    try:
        for _ in moments():
            answer = ask({"command": "samples", "trace": wanted.own, "after": 1 << 62})
            if answer["is_full"] or (wanted.trigger is None and answer["taken"] >= wanted.depth):
                return ask({"command": "samples", "trace": wanted.own})
    except KeyboardInterrupt:
        return ask({"command": "samples", "trace": wanted.own})
    why = "the trigger has not come" if answer.get("state") == "waiting" else "the samples have not come"
    raise NotStoppedError(f"{why}, samples taken: {answer.get('taken', 0)}\nthe program may be standing")


def _rows(answer: dict[str, Any]) -> list[list[str]]:
    """The samples, with the time in seconds since the trigger or the first one."""
    samples = answer["samples"]
    zero_ns = answer.get("triggered_ns") or (samples[0][0] if samples else 0)
    return [[f"{(time_ns - zero_ns) / 1e9:.6f}", *map(text_of, values)] for time_ns, *values in samples]


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(headings, *rows, strict=True)]
    return ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in (headings, *rows)]
