"""Program text in pieces of an XML file, put together so that each line keeps its number.

So the parser's messages, and later the debugger, name the line of the file that the engineer has.
"""

from dataclasses import dataclass, field


@dataclass(slots=True)
class Pieces:
    """The text of a file that is built from top to bottom."""

    lines: list[str] = field(default_factory=list)

    def add(self, text: str, line: int) -> None:
        """Put a text where it is in the file: its first line is line `line`, counted from 1.

        If an earlier piece reaches further down, the text follows it, and its lines are too high.
        """
        parts = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        while parts and not parts[0].strip():
            parts, line = parts[1:], line + 1
        self.lines += [""] * (line - 1 - len(self.lines))
        self.lines += parts

    def close(self, text: str) -> None:
        """Add a keyword of ours, such as END_PROGRAM, on the last line unless a comment may hide it there."""
        if self.lines and "//" not in self.lines[-1]:
            self.lines[-1] += f" {text}"
        else:
            self.lines.append(text)

    def text(self) -> str:
        return "\n".join(self.lines) + "\n"
