"""Parse the text of an ARP program into its tree, and report all mistakes at once.

Source: manual 5; digest chapter 3 (grammar) and chapter 18 (interpretations).  An instruction never extends beyond its
line, so an unreadable line causes one message and affects no other line.  The parser is written by hand, one function
per rule. lark could read the grammar too, but takes 37 ms more to import, reports only which terminals could have
followed an error, and would need the tables of `instructions` a second time as rules; here the same tables say what was
expected, in the manual's words.

Hexadecimal numbers and names look alike (HEAD).  A word that the program defines as a name is that name (digest 3, rule
4), so names are collected before the lines are read.
"""

import re
from collections.abc import Collection, Iterable

from fieldrig_devices.arp.language.habits import in_words_of_the_language
from fieldrig_devices.arp.language.line import LineReader, label_of
from fieldrig_devices.arp.language.tokens import LONGEST_LINE, Kind, Token, tokens
from fieldrig_devices.arp.language.tree import Equ, Line, Program, Routine
from fieldrig_devices.languages.mistakes import LineError, Mistake

_DEFINES = re.compile(r"\bBEGA?\s+([A-Z]\w*)|\b([A-Z]\w*)(?=\s*:|\s+EQU\b)", re.IGNORECASE | re.ASCII)
_ENDS = {"END": False, "ENDA": True}
_BEGINS = {"BEG": False, "BEGA": True}


def parse(text: str) -> tuple[Program, list[Mistake]]:
    """Parse a program as far as possible, and return it with its mistakes.  Names are not resolved yet (`resolve`)."""
    return parse_lines(enumerate(re.split(r"\r\n|\n|\r", text), start=1))


def parse_lines(numbered: Iterable[tuple[int, str]], longest: int = LONGEST_LINE) -> tuple[Program, list[Mistake]]:
    """Parse lines that carry their own numbers."""
    source = list(numbered)
    reader = _ProgramReader(_names(text for _, text in source), longest)
    for number, text in source:
        reader.line(number, text.rstrip())
    return reader.end()


def _names(lines: Iterable[str]) -> set[str]:
    defined = (match for line in lines for match in _DEFINES.findall(line.partition(";")[0]))
    return {name.upper() for match in defined for name in match if name}


class _ProgramReader:
    """Groups lines into routines."""

    def __init__(self, names: Collection[str], longest: int) -> None:
        self._names, self._longest = names, longest
        self._mistakes: list[Mistake] = []
        self._routines: list[Routine] = []
        self._outside: list[Line] = []
        self._lines: list[Line] = []
        self._open: tuple[int, str, bool] | None = None
        """Line, name and kind (True for an interrupt routine) of the routine that is open, or None outside of routines.
        """

    def line(self, number: int, text: str) -> None:
        try:
            if len(text) > self._longest:
                raise LineError(self._longest + 1, f"the line has {len(text)} characters", f"at most {self._longest}")
            self._read(number, tokens(text))
        except LineError as unread:
            wrong = in_words_of_the_language(text, unread)
            self._mistakes.append(Mistake(number, wrong.column, wrong.what, wrong.expected))
            label = label_of(text, number) if self._open is not None else None
            if label is not None:  # jumps to the label, and duplicates of it, are still checked
                self._lines.append(label)

    def end(self) -> tuple[Program, list[Mistake]]:
        if self._open is not None:
            number, name, is_interrupt = self._open
            end = "ENDA" if is_interrupt else "END"
            self._mistakes.append(Mistake(number, 1, f"{name} has no end", end))
            self._close(number)
        if not self._routines:
            self._mistakes.append(Mistake(1, 1, "there is no main program", "BEG name ... END"))
        elif self._routines[0].is_interrupt:
            first = self._routines[0]
            what = f"the first routine is the main program, and {first.name} is an interrupt routine"
            self._mistakes.append(Mistake(first.number, 1, what, "BEG"))
        return Program(tuple(self._routines), tuple(self._outside)), sorted(self._mistakes)

    def _read(self, number: int, words: list[Token]) -> None:
        word = words[0].text if words[0].kind is Kind.WORD else ""
        reader = LineReader(words, self._names)
        if word in _BEGINS and not words[1].is_sign(":"):
            name = reader.begin()
            self._begin(number, name, _BEGINS[word])
        elif word in _ENDS and not words[1].is_sign(":"):
            self._end(number, words[0], _ENDS[word])
            reader.single_word()
        elif words[0].kind is not Kind.END:
            self._content(number, reader)
        self._mistakes += (Mistake(number, column, what, "", is_note=True) for column, what in reader.notes)

    def _begin(self, number: int, name: str, is_interrupt: bool) -> None:
        if self._open is not None:
            begun, before, was_interrupt = self._open
            end = "ENDA" if was_interrupt else "END"
            what = f"{before}, which begins in line {begun}, has no end"
            self._mistakes.append(Mistake(number, 1, what, end))
            self._close(number - 1)
        self._open = (number, name, is_interrupt)

    def _end(self, number: int, token: Token, is_interrupt: bool) -> None:
        if self._open is None:
            raise LineError(token.column, f"{token.text} ends nothing", "BEG name or BEGA name before it")
        _, name, was_interrupt = self._open
        self._close(number)
        if is_interrupt is not was_interrupt:
            end = "ENDA" if was_interrupt else "END"
            raise LineError(token.column, f"{token.text} cannot end {name}", end)

    def _close(self, number: int) -> None:
        assert self._open is not None
        begun, name, is_interrupt = self._open
        self._routines.append(Routine(name, is_interrupt, tuple(self._lines), begun, number))
        self._lines, self._open = [], None

    def _content(self, number: int, reader: LineReader) -> None:
        line = reader.line(number)
        if self._open is not None:
            self._lines.append(line)
        elif line.label is None and isinstance(line.content, Equ):
            self._outside.append(line)
        else:
            raise LineError(reader.first_column, "this is outside of every routine", "BEG name before it, or EQU")
