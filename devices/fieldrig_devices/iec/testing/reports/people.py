"""The report for people: a line for each test, and each failure with its source, its values and its signals."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Final

from fieldrig_devices.iec.literal_texts import long_time_text
from fieldrig_devices.iec.testing.case import FAULT, MISTAKE, TIMEOUT, Failure, Outcome, Verdict

_WORDS: Final = {
    Verdict.PASSED: "ok     ",
    Verdict.FAILED: "FAILED ",
    Verdict.SKIPPED: "skipped",
    Verdict.ERROR: "ERROR  ",
}


def line_of(outcome: Outcome) -> str:
    """Return the line of one test."""
    facts = []
    if outcome.reason:
        facts.append(outcome.reason)
    if outcome.duration_ns:
        facts.append(instant(outcome.duration_ns))
    told = f"  ({', '.join(facts)})" if facts else ""
    return f"  {_WORDS[outcome.verdict]} {outcome.case.name}{told}"


def details(outcomes: Iterable[Outcome]) -> Iterator[str]:
    """Yield the lines about the tests that did not pass; the mistakes of a file only once."""
    told: set[Failure] = set()
    for outcome in outcomes:
        mistakes = [one for one in outcome.failures if one.kind == MISTAKE]
        others = [one for one in outcome.failures if one.kind != MISTAKE]
        for mistake in mistakes:
            if mistake not in told:
                told.add(mistake)
                yield f"{place(mistake)}: {_of_mistake(mistake)}"
                if mistake.message:
                    yield f"  hint: {mistake.message}"
        if others:
            yield ""
            yield f"{_WORDS[outcome.verdict].strip()} {outcome.case.suite}: {outcome.case.name}"
            for line in outcome.output:
                yield f"    | {line}"
            for failure in others:
                yield from _of_failure(failure, outcome)


def _of_mistake(mistake: Failure) -> str:
    return f"{mistake.actual}; expected {mistake.expected}" if mistake.expected else mistake.actual


def place(failure: Failure) -> str:
    return f"{failure.file}:{failure.line}" if failure.line else str(failure.file)


def _of_failure(failure: Failure, outcome: Outcome) -> Iterator[str]:
    text = source_line(failure.file, failure.line)
    yield f"  {place(failure)}"
    if text:
        yield f"    {text}"
    yield f"    {said(failure)}"
    is_counted = outcome.asserts and failure.kind not in (FAULT, TIMEOUT)
    if is_counted or failure.at_ns:
        count = f"assertion {outcome.asserts}" if is_counted else "ended"
        yield f"    {count} at {instant(failure.at_ns)}"
    for line in failure.diagram:
        yield f"      {line}"


def said(failure: Failure) -> str:
    """Return what is wrong in one line: both values, and the message of the test."""
    if failure.kind == MISTAKE:
        return "; ".join(
            filter(None, (failure.actual, failure.expected and f"expected {failure.expected}", failure.message))
        )
    text = f"expected {failure.expected}, got {failure.actual}" if failure.expected else failure.actual
    if failure.message:
        text = f"{failure.message}: {text}" if text else failure.message
    return text or failure.kind


def instant(at_ns: int) -> str:
    """Return a virtual time as the language writes it, such as T#1s200ms."""
    return f"T#{long_time_text(at_ns).partition('#')[2]}"


@lru_cache(maxsize=1_000)
def _lines(file: Path) -> Sequence[str]:
    try:
        return file.read_bytes().decode("utf-8", errors="replace").splitlines()
    except OSError:  # it has gone since
        return ()


def source_line(file: Path, line: int) -> str:
    """Return a line of a source file without its indentation; empty if there is none."""
    lines = _lines(file) if line else ()
    return lines[line - 1].strip() if 0 < line <= len(lines) else ""


def summary(outcomes: Sequence[Outcome], wall_s: float) -> str:
    counts = Counter(outcome.verdict for outcome in outcomes)
    words = {Verdict.PASSED: "passed", Verdict.FAILED: "failed", Verdict.ERROR: "errors", Verdict.SKIPPED: "skipped"}
    if counts[Verdict.ERROR] == 1:
        words[Verdict.ERROR] = "error"
    parts = [f"{counts[verdict]} {word}" for verdict, word in words.items() if counts[verdict]]
    return f"{counted(len(outcomes))}: {', '.join(parts) or 'nothing ran'} in {wall_s:.2f} s"


def counted(number: int) -> str:
    return "1 test" if number == 1 else f"{number} tests"
