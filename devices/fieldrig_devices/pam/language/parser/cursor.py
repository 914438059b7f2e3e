"""The position of the parser in the tokens, and its messages."""

from typing import Final

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.items import Parameter
from fieldrig_devices.pam.language.tokens import Token, mistake
from fieldrig_devices.pam.language.tree import Index, Place
from fieldrig_devices.pam.language.words import LABEL_KEYWORDS

DEEPEST: Final = 60
"""Levels of statements or of expressions in each other."""
_INDICES: Final[dict[str, Index]] = {"[i]": "i", "[all]": "all", "[all+]": "all+", "[all*]": "all*"}


class UnexpectedError(Exception):
    """The mistake that stops the parser in a statement or declaration.  It has been reported."""


class Cursor:
    """Reads tokens one by one.  Keywords are read in any case, names are not (section 1.1)."""

    def __init__(self, tokens: list[Token], names: frozenset[str] = frozenset()) -> None:
        """`names` are names of the program, which are no keywords in this spelling."""
        self.tokens, self._names = tokens, names
        self.i = 0
        self.depth = 0
        self.mistakes: list[Mistake] = []
        self._reported = -1
        """The last token that a mistake was reported for; a second one for it follows from the first."""
        self._closed: list[tuple[str, int, int]] = []
        """The words that have ended something, with the numbers of its first token and of the word."""

    @property
    def token(self) -> Token:
        return self.tokens[self.i]

    @property
    def place(self) -> Place:
        return self.tokens[self.i].place

    @property
    def is_at_end(self) -> bool:
        return self.token.kind == "end"

    def take(self) -> Token:
        """Return the present token and go to the next one.  The end of the text is never passed."""
        token = self.tokens[self.i]
        if token.kind != "end":
            self.i += 1
        return token

    def is_name(self, token: Token) -> bool:
        """True for a name of the program that differs from a keyword by its case only."""
        return token.text in self._names

    def is_word(self, *words: str) -> bool:
        """True if the present token is one of these keywords."""
        return self.spells(*words) and not self.is_name(self.token)

    def spells(self, *words: str) -> bool:
        """True if the present token is one of these words, also where the program has a name that is spelled so."""
        return self.token.kind == "name" and self.token.text.upper() in words

    @property
    def following(self) -> Token:
        return self.tokens[min(self.i + 1, len(self.tokens) - 1)]

    def is_next(self, *words: str) -> bool:
        """True if the token behind the present one is one of these words or signs."""
        return self.following.text.upper() in words

    def is_one_line(self, begin: int) -> bool:
        """True if no token behind this one up to the next one begins a line, and neither does the one itself."""
        return not any(token.begins_line for token in self.tokens[begin : self.i + 2])

    def accept(self, text: str) -> bool:
        """Pass over a word or sign if it is the present token."""
        if self.is_word(text) or (self.token.kind == "sign" and self.token.text == text):
            self.take()
            return True
        return False

    def expect(self, text: str, hint: str = "") -> None:
        if not self.accept(text):
            raise self.unexpected(text, hint)

    def close(self, text: str, begin: int | None = None) -> None:
        """Pass over the word or sign that ends something; report it if it is missing, and go on.

        `begin` is the number of the first token of what it ends.
        """
        at = self.i
        if not self.accept(text):
            self.missing(text, "" if begin is None else self._belonging(text, begin))
        elif begin is not None:
            self._closed.append((text, begin, at))

    def _belonging(self, text: str, begin: int) -> str:
        """Return the hint that says what a missing word belongs to.

        The words that are there have gone to the innermost beginnings.  One that is further to the left than its
        beginning belongs to an outer one, and then that beginning has none.
        """
        inner = [
            first for word, first, last in self._closed if word == text and first > begin and self._is_left(last, first)
        ]
        first = self.tokens[max(inner, default=begin)]
        file = f" of {first.place.file}" if first.place.file != self.place.file else ""
        return f"It belongs to the {first.text.upper()} in line {first.place.line}{file}."

    def _is_left(self, last: int, first: int) -> bool:
        end, begin = self.tokens[last], self.tokens[first]
        return end.begins_line and begin.begins_line and end.place.column < begin.place.column

    def semicolon(self, *, is_optional: bool = False) -> None:
        """Pass over a semicolon.  The listings leave some out, which is worth a note where that is known."""
        if self.accept(";"):
            return
        if self._is_decimal_comma():
            return
        if is_optional:
            self._say(self.i, "a semicolon is missing", "", is_note=True)
        else:
            self.missing(";")

    def _is_decimal_comma(self) -> bool:
        """Report 1,5 for 1.5, and pass over it with its semicolon."""
        before, behind = self.tokens[self.i - 1], self.following
        if self.token.text != "," or {before.kind, behind.kind} != {"integer"}:
            return False
        self.wrong(before.place, f"got {before.text},{behind.text}", f"{before.text}.{behind.text}")
        self.i += 2
        self.accept(";")
        return True

    def name(self, what: str, hint: str = "Choose another name.") -> str:
        """Read a name; `what` says what it is the name of, and `hint` what to do about a reserved word."""
        if self.token.kind != "name":
            raise self.unexpected(what)
        if self.token.text.upper() in LABEL_KEYWORDS and not self.is_name(self.token):
            raise self.unexpected(what, f"{self.token.text} is a reserved word. {hint}".rstrip())
        return self.take().text

    def index(self) -> Index | None:
        known = _INDICES.get(self.token.text)
        if known is not None:
            self.take()
        return known

    def item_index(self) -> bool:
        """Pass over [i], which marks a sequence or equation of several items."""
        if self.token.text in ("[all]", "[all+]", "[all*]"):
            raise self.unexpected("[i]")
        return self.index() is not None

    # ---- mistakes

    def unexpected(self, expected: str, hint: str = "") -> UnexpectedError:
        """Report that the present token is not what was expected.  The caller raises what this returns."""
        self._say(self.i, f"got {self.shown(self.i)}", expected, hint=hint)
        return UnexpectedError()

    def missing(self, what: str, hint: str = "") -> None:
        """Report that something is missing behind the last token."""
        if self._reported >= self.i or self.i == 0:
            return
        last = self.tokens[self.i - 1]
        self._reported = self.i
        place = Place(last.place.file, last.place.line, last.place.column + len(last.text))
        self.mistakes.append(mistake(place, f"{what} is missing behind {self.shown(self.i - 1)}", "", hint))

    def note(self, place: Place, what: str, hint: str = "") -> None:
        """Say something about a program that compiles all the same."""
        self.mistakes.append(mistake(place, what, "", hint, is_note=True))

    def wrong(self, place: Place, what: str, expected: str = "", hint: str = "") -> None:
        self.mistakes.append(mistake(place, what, expected, hint))

    def shown(self, at: int) -> str:
        text = self.tokens[at].text
        return text if len(text) <= 40 else f"{text[:37]}..."

    def _say(self, at: int, what: str, expected: str, hint: str = "", *, is_note: bool = False) -> None:
        if at > self._reported or is_note:
            self._reported = max(at, self._reported) if not is_note else self._reported
            self.mistakes.append(mistake(self.tokens[at].place, what, expected, hint, is_note=is_note))

    # ---- levels and recovery

    def deeper(self) -> None:
        """Enter another level.  UnexpectedError beyond the limit."""
        self.depth += 1
        if self.depth > DEEPEST:
            self.depth -= 1
            raise self.unexpected(f"at most {DEEPEST} nested levels")

    def higher(self) -> None:
        self.depth -= 1

    def recover(self, begin: int, depth: int, *words: str) -> None:
        """Go on behind what was not understood, at the next of these words or signs and with the levels of before.

        `begin` is the token that it began with.  That one is passed over in any case, so that a parser comes forward.
        """
        self.depth = depth
        if self.i <= begin:
            self.take()
        self.skip_to(*words)

    def skip_to(self, *words: str) -> None:
        """Go to the next of these words or signs, or to the end, without passing over it."""
        while not self.is_at_end and (self.token.text.upper() not in words or self.is_name(self.token)):
            self.take()

    def checked_once(self, parameters: list[Parameter], added: Parameter) -> None:
        """Report a parameter that appears twice."""
        if any(known.name == added.name for known in parameters):
            self.wrong(added.place, f"{added.name} appears twice", "each parameter once")
