"""Properties of programs: what has to hold for all sequences of inputs over time.

Random sequences are tried, and one that breaks the property is made as short as it can be.  Hypothesis makes the
sequences and their values; the extra `properties` installs it.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from importlib import import_module
from typing import Any, Final, NamedTuple

from fieldrig.errors import ArgumentError, RigError, UnmetError, UsageError
from fieldrig.outside.untrusted import shown
from fieldrig.shrinking import fewest, least

INSTALL: Final = "pip install 'fieldrig[properties]'"
CYCLES: Final = (1, 2, 5, 10, 20, 50, 100)
"""The numbers of cycles for which inputs stay as they are; others come from steps in which nothing changes."""


class Step(NamedTuple):
    """Inputs that change, and the number of cycles for which they then stay."""

    changes: Mapping[str, Any]
    cycles: int

    def __str__(self) -> str:
        changes = ", ".join(f"{name} = {value!r}" for name, value in self.changes.items()) or "nothing changes"
        return f"{changes}; 1 cycle" if self.cycles == 1 else f"{changes}; {self.cycles} cycles"


Play = Callable[[Sequence[Step]], None]
"""Plays steps from the begin of the program; it raises RigError where the property does not hold."""


def hypothesis() -> Any:
    """Return the library.  UsageError, with the extra, where it is missing."""
    try:
        return import_module("hypothesis")
    except ImportError as missing:
        raise UsageError(f"properties need the package {missing.name or 'hypothesis'}", INSTALL) from missing


def explore(play: Play, inputs: Mapping[str, Any], steps: int, examples: int, seed: int | None) -> None:
    """Play random sequences of at most `steps` steps; `inputs` are strategies of hypothesis by the names of the inputs.

    Without `seed` they are the same in each run.  UnmetError, with the shortest sequence, if the property does not
    hold, or if a fault ends the program.
    """
    for name, number in (("steps", steps), ("examples", examples)):
        if type(number) is not int or number < 1:
            raise ArgumentError(f"{name} cannot be {shown(number)}", "expected a number from 1 on")
    of = hypothesis().strategies
    changes = of.fixed_dictionaries({}, optional=dict(inputs))
    step = of.builds(Step, changes, of.sampled_from(CYCLES))
    failing = _failing(play, of.lists(step, min_size=1, max_size=steps), examples, seed)
    if failing is not None:
        short = _Shrinking(play, inputs).shrunk(failing)
        wrong = _failure(play, short)
        assert wrong is not None, "what fails is played again from the begin"
        raise UnmetError(wrong.what, "\n".join([*map(str, short), *filter(None, [wrong.remedy])]))


def _failure(play: Play, sequence: Sequence[Step]) -> RigError | None:
    """Return why a sequence fails; None if it does not.  ArgumentError for an input that takes no such value."""
    try:
        play(sequence)
    except ArgumentError:
        raise
    except RigError as wrong:
        return wrong
    return None


def _failing(play: Play, sequences: Any, examples: int, seed: int | None) -> Sequence[Step] | None:
    """Return the first sequence that fails.  The library does not shrink it: it knows nothing of time."""
    library, found = hypothesis(), list[Sequence[Step]]()

    def tried(sequence: Sequence[Step]) -> None:
        if not found and _failure(play, sequence) is not None:
            found.append(sequence)

    test = library.given(sequences)(tried)
    test = test if seed is None else library.seed(seed)(test)
    _settings(examples, is_seeded=seed is not None)(test)()
    return found[0] if found else None


def _settings(examples: int, *, is_seeded: bool = False) -> Any:
    library = hypothesis()
    return library.settings(
        max_examples=examples,
        deadline=None,
        database=None,
        derandomize=not is_seeded,
        suppress_health_check=list(library.HealthCheck),
    )


class _Shrinking:
    """Fewer steps, fewer changes, shorter times, and then simpler values, as long as it fails."""

    def __init__(self, play: Play, inputs: Mapping[str, Any]) -> None:
        self._play, self._inputs = play, inputs

    def shrunk(self, sequence: Sequence[Step]) -> list[Step]:
        steps = _joined(fewest(sequence, self._fails))
        parts = [(number, name) for number, step in enumerate(steps) for name in step.changes]
        kept = set(fewest(parts, lambda some: self._fails(_with(steps, set(some)))))
        steps = _joined(_with(steps, kept))
        for number in range(len(steps)):
            steps = self._shorter(steps, number)
        for number, step in enumerate(steps):
            for name in step.changes:
                steps = self._simpler(steps, number, name)
        return steps

    def _fails(self, sequence: Sequence[Step]) -> bool:
        return _failure(self._play, sequence) is not None

    def _shorter(self, steps: Sequence[Step], number: int) -> list[Step]:
        """Return the steps with the smallest number of cycles in one of them."""
        changes, cycles = steps[number]
        shortest = least(cycles, 1, lambda some: self._fails(_replaced(steps, number, changes, some)))
        return _replaced(steps, number, changes, shortest)

    def _simpler(self, steps: Sequence[Step], number: int, name: str) -> list[Step]:
        """Return the steps with the simplest value of an input."""

        def made(value: Any) -> list[Step]:
            changes, cycles = steps[number]
            return _replaced(steps, number, {**changes, name: value}, cycles)

        library = hypothesis()
        try:
            return made(
                library.find(self._inputs[name], lambda value: self._fails(made(value)), settings=_settings(50))
            )
        except library.errors.NoSuchExample:  # it is rare
            return list(steps)


def _with(steps: Sequence[Step], kept: Collection[tuple[int, str]]) -> list[Step]:
    """Return the steps with only those changes that are kept."""
    return [
        Step({name: value for name, value in changes.items() if (number, name) in kept}, cycles)
        for number, (changes, cycles) in enumerate(steps)
    ]


def _replaced(steps: Sequence[Step], number: int, changes: Mapping[str, Any], cycles: int) -> list[Step]:
    return [*steps[:number], Step(changes, cycles), *steps[number + 1 :]]


def _joined(sequence: Sequence[Step]) -> list[Step]:
    """Return the same sequence without steps in which nothing changes, as far as it can be said so."""
    joined: list[Step] = []
    for step in sequence:
        if joined and not step.changes:
            joined[-1] = Step(joined[-1].changes, joined[-1].cycles + step.cycles)
        else:
            joined.append(step)
    return joined
