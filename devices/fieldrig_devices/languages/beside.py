"""Compiling a program beside the controller that it is for, in a process of its own.

In virtual time the result comes after a time that depends on the length of the sources.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar

from fieldrig.loop.background import Background, Failure, Job, Report
from fieldrig_devices.languages.mistakes import Mistake

NS_PER_CHARACTER: Final = 5_000
"""Virtual time that compiling takes, in nanoseconds."""

C = TypeVar("C")
"""A compiled program."""


@dataclass(frozen=True, slots=True)
class Refused:
    """A program that cannot be compiled."""

    mistakes: tuple[Mistake, ...]

    def __str__(self) -> str:
        return text_of(self.mistakes)


def text_of(mistakes: Sequence[Mistake]) -> str:
    """The mistakes, one a line, without notes."""
    return "\n".join(str(mistake) for mistake in mistakes if not mistake.is_note)


def duration_of(texts: Iterable[str]) -> int:
    """Virtual time that compiling these texts takes, in nanoseconds."""
    return NS_PER_CHARACTER * sum(map(len, texts))


class Beside(Generic[C]):
    """The compiler of one controller, which compiles one program at a time; a new one takes the place of the last."""

    def __init__(self, background: Background) -> None:
        self._background = background
        self._job: Job | None = None
        self.progress = ""
        """How far the compiler is; empty if there is nothing to do."""

    def compile(
        self,
        work: Callable[[Any, Report], C | Refused],
        order: Any,
        duration_ns: int,
        on_done: Callable[[C | str], None],
    ) -> None:
        """Call `work(order, report)` beside the controller, and `on_done` with a program, or why there is none."""

        def on_result(result: C | Refused | Failure) -> None:
            self._job, self.progress = None, ""
            on_done(
                result.why if isinstance(result, Failure) else str(result) if isinstance(result, Refused) else result
            )

        def on_progress(what: str, done: int, steps: int) -> None:
            self.progress = f"{what} {100 * done // max(steps, 1)} %"

        self.cancel()
        self.progress = "compiling 0 %"
        self._job = self._background.run(work, order, on_result, on_progress, virtual_ns=duration_ns)

    def cancel(self) -> None:
        """Drop what is being compiled."""
        if self._job is not None:
            self._job.cancel()
        self._job, self.progress = None, ""
