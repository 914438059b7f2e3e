"""Values that are not as in the log, over several messages: one difference for each value and each bit.

A bit that the rig sets 14 ms later than the log is other data in every message of these 14 ms.  So a difference begins
with the first of them, and ends when both agree again: then it is known which of the two changed, and when.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from fieldrig.points.values import counted
from fieldrig.traces.parts import Part, PartDifference
from fieldrig_devices.replay.replay_result import Difference, ReplayResult, What
from fieldrig_devices.replay.tolerances import Tolerances
from fieldrig_devices.replay.words import late_words

MOST_OPEN: Final = 10_000


class Subject(NamedTuple):
    """The messages that a value belongs to."""

    bus: str
    node: str
    name: str
    """The PDO, the object that was read, the registers."""
    begin: str
    """The beginning of the sentence, `{}` for the value: `io sent TPDO 1 with {}`, `node 3 answered {} with`."""


@dataclass(slots=True)
class _Run:
    subject: Subject
    part: PartDifference
    mask: int
    """The bits that differ; 0 for a value without bits."""
    expected_ns: int
    actual_ns: int
    late_ns: int
    messages: int = 1
    most: float = 0.0


class Runs:
    """The values that differ at present."""

    def __init__(self, result: ReplayResult, tolerances: Tolerances) -> None:
        self._result, self._tolerances = result, tolerances
        self._open: dict[tuple[Subject, str], list[_Run]] = {}
        self._by_subject: dict[Subject, set[str]] = {}

    def take(
        self, subject: Subject, expected: Sequence[Part], actual: Sequence[Part], times_ns: tuple[int, int]
    ) -> bool:
        """Take two messages that belong together, with their instants; return whether they differ."""
        self._tolerances.look_at(subject.node, expected)
        found = {part.key: part for part in self._tolerances.differences(subject.node, expected, actual)}
        if subject in self._by_subject:
            came = {part.key: part.value for part in actual}
            for key in list(self._by_subject[subject]):
                self._end_those_that_agree(subject, key, found.get(key), came.get(key), times_ns)
        for key, part in found.items():
            self._go_on(subject, key, part, times_ns)
        return bool(found)

    def is_open(self, subject: Subject) -> bool:
        """Return whether a value of these messages differs at present."""
        return bool(self._by_subject.get(subject))

    def finish(self) -> None:
        """Report everything that still differs."""
        for runs in self._open.values():
            for run in runs:
                self._report(run, "")
        self._open.clear()
        self._by_subject.clear()

    def _go_on(self, subject: Subject, key: str, part: PartDifference, times_ns: tuple[int, int]) -> None:
        flipped = _mask(part)
        runs = self._open.setdefault((subject, key), [])
        covered = 0
        for run in runs:
            run.messages += 1
            run.most = max(run.most, _distance(part))
            covered |= run.mask
        if (flipped & ~covered) if flipped else not runs:
            new = flipped & ~covered
            late_ns = times_ns[1] - times_ns[0]
            runs.append(_Run(subject, part, new, *times_ns, late_ns, most=_distance(part)))
            self._by_subject.setdefault(subject, set()).add(key)
            if len(self._open) > MOST_OPEN:
                self._report_oldest()

    def _end_those_that_agree(
        self,
        subject: Subject,
        key: str,
        part: PartDifference | None,
        value: int | float | str | None,
        times_ns: tuple[int, int],
    ) -> None:
        flipped = 0 if part is None else _mask(part)
        left = []
        for run in self._open.get((subject, key), ()):
            is_over = part is None if not run.mask else not flipped & run.mask
            if is_over:
                self._report(run, _when(run, value, times_ns))
            else:
                left.append(run)
        if left:
            self._open[subject, key] = left
        else:
            self._open.pop((subject, key), None)
            self._by_subject.get(subject, set()).discard(key)

    def _report_oldest(self) -> None:
        where = next(iter(self._open))
        for run in self._open.pop(where):
            self._report(run, "")
        self._by_subject.get(where[0], set()).discard(where[1])

    def _report(self, run: _Run, when: str) -> None:
        part, subject = run.part, run.subject
        expected = "nothing" if part.expected is None else part.expected.text
        actual = "nothing" if part.actual is None else part.actual.text
        bits = _named(part, run.mask)
        words = f"{subject.begin.replace('{}', part.label)} {actual}, the log says {expected}"
        words += f": {bits}{when}" if bits else when
        if run.messages > 1:
            most = f", by at most {run.most:.6g}" if run.most and not run.mask else ""
            words += f" (in {counted(run.messages, 'message')}{most})"
        self._result.add(
            Difference(run.expected_ns, What.OTHER, subject.bus, subject.node, part.label, words, run.late_ns, (part,))
        )


def _when(run: _Run, value: int | float | str | None, times_ns: tuple[int, int]) -> str:
    """Return how much later or earlier the rig came to the value, now that both agree in it."""
    if _is_as(run.part.expected, value, run.mask):
        by_ns = times_ns[1] - run.expected_ns
    elif _is_as(run.part.actual, value, run.mask):
        by_ns = run.actual_ns - times_ns[0]
    else:
        return ""
    return f", came {late_words(by_ns)}" if by_ns else ""


def _is_as(part: Part | None, value: int | float | str | None, mask: int) -> bool:
    if part is None or value is None:
        return False
    if mask and isinstance(value, int) and isinstance(part.value, int):
        return not (part.value ^ value) & mask
    return part.value == value


def _mask(part: PartDifference) -> int:
    """Return the bits that differ; 0 for a value without bits."""
    expected, actual = part.expected, part.actual
    if expected is None or actual is None or not expected.bits:
        return 0
    if not isinstance(expected.value, int) or not isinstance(actual.value, int):
        return 0
    return expected.value ^ actual.value


def _distance(part: PartDifference) -> float:
    expected, actual = part.expected, part.actual
    if expected is None or actual is None:
        return 0.0
    if isinstance(expected.value, str) or isinstance(actual.value, str):
        return 0.0
    return abs(float(actual.value) - float(expected.value))


def _named(part: PartDifference, mask: int) -> str:
    """Return the names of these bits."""
    if part.expected is None:
        return ""
    names = part.expected.bits
    return "; ".join(f"bit {bit}{f', {names[bit]}' if names.get(bit) else ''}" for bit in range(64) if mask >> bit & 1)
