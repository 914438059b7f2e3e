"""The lines of a text that is being printed, with their indentation and comments."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from fieldrig_devices.iec import tree

INDENT = "    "


class Lines:
    """Collects lines."""

    def __init__(self) -> None:
        self._lines: list[str] = []
        self._depth = 0

    def text(self) -> str:
        return "".join(f"{line}\n" for line in self._lines)

    @property
    def indentation(self) -> str:
        return INDENT * self._depth

    def add(self, text: str) -> None:
        self._lines.append(f"{self.indentation}{text}" if text else "")

    def comment(self, text: str) -> None:
        """Add a comment; the further lines of a long one stay as they are."""
        self._lines.append(f"{self.indentation}{text}")

    def append(self, text: str) -> None:
        """Add to the last line."""
        self._lines[-1] += text

    @contextmanager
    def indented(self, levels: int = 1) -> Iterator[None]:
        self._depth += levels
        yield
        self._depth -= levels

    def front(self, statement: tree.Statement, is_first: bool = True) -> None:
        """Add an empty line and the comments in front of a statement."""
        if statement.is_spaced and not is_first:
            self.add("")
        for comment in statement.comments:
            self.comment(comment)

    def behind(self, statement: tree.Statement) -> None:
        """Add the comment in the last line of a statement, and those at the end of its block."""
        if statement.remark:
            self.append(f" {statement.remark}")
        for comment in statement.after:
            self.comment(comment)

    def comments(self, comments: Sequence[str]) -> None:
        for comment in comments:
            self.comment(comment)
