"""A switch of this process: the change with which programs are compiled, or the list of all changes that there are.

It is one for the whole process, as that of coverage is (`coverage.collecting`): the compilers of all devices of a rig
have to see it, and a rig's file says nothing of it.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.mutation.changes import Change, changes_of


@dataclass
class Survey:
    """The changes of all programs that were compiled meanwhile."""

    changes: dict[Change, None] = field(default_factory=dict)


@dataclass
class Applied:
    """The change with which programs are compiled."""

    change: Change | None
    is_refused: bool = False
    """True if a program did not compile with it."""


_surveys: list[Survey] = []
_applied: list[Applied] = []


@contextmanager
def surveying() -> Iterator[Survey]:
    """Note the changes of the programs that are compiled meanwhile."""
    _surveys.append(Survey())
    try:
        yield _surveys[-1]
    finally:
        _surveys.pop()


@contextmanager
def applied(change: Change | None) -> Iterator[Applied]:
    """Compile programs with this change meanwhile; with None, as they are."""
    _applied.append(Applied(change))
    try:
        yield _applied[-1]
    finally:
        _applied.pop()


def present() -> Change | None:
    """Return the change with which programs are compiled now."""
    return _applied[-1].change if _applied else None


def note(changes: Iterable[Change], *, is_refused: bool) -> None:
    """Take note of what another process, which has run tests for this one, knows of its programs."""
    for survey in _surveys[-1:]:
        survey.changes.update(dict.fromkeys(changes))
    for one in _applied[-1:]:
        one.is_refused |= is_refused


def refuse(files: Iterable[str]) -> None:
    """Take note that a program of these files did not compile."""
    for one in _applied[-1:]:
        one.is_refused |= one.change is not None and one.change.file in files


def changed(units: Sequence[tree.Unit], left_out: Collection[str] = ()) -> Sequence[tree.Unit]:
    """Return the files of a program with the change that is wanted, if any; those given stay as they are.

    `left_out` are the names, in small letters, of POUs that are no part of the program.
    """
    for survey in _surveys[-1:]:
        survey.changes.update({made.change: None for unit in units for made in changes_of(unit, left_out)})
    change = present()
    return units if change is None else [_with(change, unit) for unit in units]


def _with(change: Change, unit: tree.Unit) -> tree.Unit:
    made = (made for made in changes_of(unit) if made.change == change) if unit.file == change.file else ()
    return next((made.made_in(unit) for made in made), unit)
