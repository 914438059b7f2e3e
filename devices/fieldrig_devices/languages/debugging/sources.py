"""The source files of a program, as its device has them, and places in them as people write them: `FILE:LINE`."""

from typing import NamedTuple

from fieldrig_devices.languages.debugging.adapter import Ask


class Place(NamedTuple):
    """A line of a source file."""

    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


class Sources:
    """The files of one device; each is read once, and again when the list of files has changed."""

    def __init__(self, ask: Ask) -> None:
        self._ask = ask
        self._texts: dict[str, list[str]] = {}

    def names(self) -> list[str]:
        names: list[str] = self._ask({"command": "files"})["files"]
        return names

    def lines(self, file: str) -> list[str]:
        if file not in self._texts:
            text: str = self._ask({"command": "source", "file": file})["text"]
            self._texts[file] = text.splitlines()
        return self._texts[file]

    def line(self, place: Place) -> str:
        """The text of a line; empty for a place that the files do not have, such as one in a library."""
        if place.file not in self._texts and place.file not in self.names():
            return ""
        text = self.lines(place.file)
        return text[place.line - 1] if 1 <= place.line <= len(text) else ""

    def place_of(self, text: str, here: Place | None) -> Place:
        """The place that `FILE:LINE` or `LINE` means; without a file, the file of the present place.

        ValueError, which says what was expected, for any other text.
        """
        file, colon, line = text.rpartition(":")
        if not line.isdecimal() or len(line) > 8 or (colon and not file):
            raise ValueError(f"{text!r} is not a place\nexpected FILE:LINE, or the number of a line")
        names = self.names()
        if not colon:
            file = here.file if here is not None and here.file in names else (names or [""])[0]
        matches = [name for name in names if name == file] or [
            name for name in names if name.casefold().endswith(file.casefold())
        ]
        if not matches or not file:
            raise ValueError(f"there is no file {file!r}\nexpected {', '.join(names) or 'a program first'}")
        return Place(matches[0], max(int(line), 1))
