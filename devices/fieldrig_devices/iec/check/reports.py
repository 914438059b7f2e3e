"""The mistakes that the checker has found, and how it words what is common to them."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Final

from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.limits import MOST_MESSAGES
from fieldrig_devices.iec.tree import Position
from fieldrig_devices.languages.mistakes import Code, Mistake

MOST_SEARCHES: Final = 25
"""Unknown names for which the closest known name is looked up; a search takes milliseconds in a large project."""


class Keys(dict[str, str]):
    """The form in which names are compared, by the name: small letters, 32 characters (PD-350)."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__()
        self._dialect = dialect

    def __missing__(self, name: str) -> str:
        self[name] = key = self._dialect.key(name)
        return key


class Reports:
    def __init__(self) -> None:
        self.mistakes: list[Mistake] = []
        self._searches = self._mistakes = self._notes = 0

    def say(
        self,
        file: str,
        position: Position,
        what: str,
        expected: str = "",
        hint: str = "",
        code: Code = Code.OTHER,
        name: str = "",
    ) -> None:
        if self._mistakes < MOST_MESSAGES:
            self._mistakes += 1
            mistake = Mistake(
                position.line, position.column, what, expected, file=file, hint=hint, code=code, name=name
            )
            self.mistakes.append(mistake)

    def note(self, file: str, position: Position, what: str, hint: str = "") -> None:
        if self._notes < MOST_MESSAGES:
            self._notes += 1
            self.mistakes.append(Mistake(position.line, position.column, what, is_note=True, file=file, hint=hint))

    def withdraw(self, first: int) -> None:
        """Forget the mistakes from this number on."""
        self._mistakes -= sum(not mistake.is_note for mistake in self.mistakes[first:])
        del self.mistakes[first:]

    def closest(self, name: str, known: Iterable[str]) -> str:
        """Return a hint that names the known name which is most alike; empty if none is."""
        self._searches += 1
        if self._searches > MOST_SEARCHES:
            return ""
        wanted = name.casefold()
        close = [other for other in known if abs(len(other) - len(wanted)) <= 2 and not other.startswith("$")]
        candidates = {other.casefold(): other for other in close}
        matches = get_close_matches(wanted, sorted(candidates), n=1, cutoff=0.6)
        return f"the closest known name is {candidates[matches[0]]}" if matches else ""
