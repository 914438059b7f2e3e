"""The words of a debugger with one command per line: names, short names, arguments, and the list of `help`."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

MOST_REPEATS: Final = 1_000


@dataclass(frozen=True, slots=True)
class Help:
    words: tuple[str, ...]
    arguments: str
    about: str


class Words:
    """The commands of one debugger."""

    def __init__(self, entries: Sequence[Help], hint: str) -> None:
        self._entries, self._hint = tuple(entries), hint
        self._width = max(len(entry.arguments) for entry in entries)
        self._name_width = max(len(", ".join(entry.words)) for entry in entries)

    def find(self, word: str) -> str:
        """Find a command by its full name, its short name or its beginning.  ValueError for an unknown command."""
        word = word.lower()
        for entry in self._entries:
            if word in entry.words:
                return entry.words[0]
        candidates = [entry.words[0] for entry in self._entries if entry.words[0].startswith(word)]
        if len(candidates) != 1:
            close = f"{word!r} is ambiguous: {' or '.join(candidates)}" if candidates else f"{word!r} is not a command"
            raise ValueError(f"{close}\n`help` lists the commands")
        return candidates[0]

    def lines(self) -> Iterator[str]:
        """Yield the text of `help`."""
        for entry in self._entries:
            yield self._shown(entry)
        yield self._hint

    def line(self, word: str) -> str:
        """Return what `help` says of a command.  ValueError for an unknown one."""
        name = self.find(word)
        return next(self._shown(entry) for entry in self._entries if entry.words[0] == name)

    def _shown(self, entry: Help) -> str:
        return f"  {', '.join(entry.words):{self._name_width}} {entry.arguments:{self._width}} {entry.about}"


def count(arguments: Sequence[str]) -> int:
    """The count in the arguments, or 1 if there are none.  ValueError for an invalid count."""
    if not arguments:
        return 1
    if len(arguments) == 1 and arguments[0].isdecimal() and 1 <= int(arguments[0]) <= MOST_REPEATS:
        return int(arguments[0])
    raise ValueError(f"{' '.join(arguments)!r} is not a count\nexpected 1 to {MOST_REPEATS}")


def none(arguments: Sequence[str]) -> None:
    if arguments:
        raise ValueError(f"unexpected {' '.join(arguments)!r} after this command\n`help` lists the commands")


def limit(arguments: Sequence[str], usual_s: float | None) -> float | None:
    """The time to wait in the arguments, in seconds, or `usual_s` if there are none.  ValueError for anything else."""
    if not arguments:
        return usual_s
    try:
        [text] = arguments
        return float(text)
    except ValueError as cause:
        raise ValueError(f"{' '.join(arguments)!r} is not a time\nexpected a number of seconds") from cause
