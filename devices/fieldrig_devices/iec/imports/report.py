"""Messages of an import: the file, the line of the XML, and the POU, network and element that an engineer looks for."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.languages.mistakes import Mistake

MESSAGES: Final = 200
"""Messages of one file; what follows them is hardly worth reading."""


@dataclass(slots=True)
class Report:
    """Collects the mistakes of one file.  `inside` adds where in the project they are."""

    file: str
    mistakes: list[Mistake] = field(default_factory=list)
    where: list[str] = field(default_factory=list)

    @contextmanager
    def inside(self, what: str) -> Iterator[None]:
        self.where.append(what)
        try:
            yield
        finally:
            self.where.pop()

    def mistake(self, line: int, what: str, expected: str = "", hint: str = "") -> None:
        self._add(Mistake(line, 1, self._placed(what), expected, file=self.file, hint=hint))

    def note(self, line: int, what: str, hint: str = "") -> None:
        self._add(Mistake(line, 1, self._placed(what), is_note=True, file=self.file, hint=hint))

    def take(self, mistakes: list[Mistake]) -> None:
        """Add what the parser found in a text of this file."""
        for mistake in mistakes:
            self._add(
                Mistake(
                    mistake.line,
                    mistake.column,
                    self._placed(mistake.what),
                    mistake.expected,
                    mistake.is_note,
                    self.file,
                    mistake.hint,
                )
            )

    def _placed(self, what: str) -> str:
        return f"{', '.join(self.where)}: {what}" if self.where else what

    def _add(self, mistake: Mistake) -> None:
        if len(self.mistakes) < MESSAGES:
            self.mistakes.append(mistake)
