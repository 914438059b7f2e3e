"""The position of the parser in the tokens, its messages, and the comments on the way."""

import re
from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.limits import MOST_MESSAGES
from fieldrig_devices.iec.tree import Position
from fieldrig_devices.languages.mistakes import Mistake

DEEPEST_EXPRESSION: Final = 100
"""Levels of the tree of an expression, so that nothing that follows it meets the limit of recursion of Python."""
LONGEST_CHAIN: Final = 20_000
"""Operators in a row, such as a OR b OR c."""
DEEPEST_BLOCK: Final = 40
"""Levels of statements, types and initial values in each other."""


TEXTS: Final = (token.STRING, token.WIDE_STRING)


class UnexpectedError(Exception):
    """The mistake that stops the parser in a statement or declaration.  It has been reported."""


class Cursor:
    """Reads tokens one by one."""

    def __init__(self, tokens: token.Tokens, file: str, dialect: Dialect) -> None:
        self.kinds, self.texts, self.positions, self.comments = (
            tokens.kinds,
            tokens.texts,
            tokens.positions,
            tokens.comments,
        )
        self.mistakes = tokens.mistakes
        self.file, self.dialect = file, dialect
        self.i = 0
        self.is_test = False
        """True within a block of a test file, which has statements of its own."""
        self.depth = 0
        self.height = 0
        self._is_cut = tokens.is_cut
        self._reported = -1
        """The last token that a mistake was reported for; a second one for the same token follows from the first."""
        self._ends: dict[int, int] = {}
        """The line in which the remark in front of a token ends."""
        self._pending: list[str] = []
        """Comments that no statement has yet."""

    # ---- mistakes

    def say(self, at: int, what: str, expected: str = "", hint: str = "") -> None:
        """Report a mistake at a token, unless one has been reported for it."""
        if at > self._reported and not (self._is_cut and self.kinds[at] == token.END):
            self._reported = at
            self.say_at(self.positions[at], what, expected, hint)

    def say_at(self, position: Position, what: str, expected: str = "", hint: str = "") -> None:
        if len(self.mistakes) < MOST_MESSAGES:
            self.mistakes.append(Mistake(*position, what, expected, file=self.file, hint=hint))

    def unexpected(self, expected: str, hint: str = "", at: int = -1) -> UnexpectedError:
        """Report that the present token is not what was expected.  The caller raises what this returns."""
        where = self.i if at < 0 else at
        if not hint and where > 0 and self.kinds[where] == self.kinds[where - 1] == token.STRING:
            hint = "A quote within a text is $'."
        self.say(where, f"got {self.shown(where)}", expected, hint)
        return UnexpectedError()

    def shown(self, at: int) -> str:
        """Return a token as messages show it."""
        if self.kinds[at] == token.END:
            return "the end of the text"
        text = self.texts[at]
        return text if len(text) <= 40 else f"{text[:37]}..."

    def missing(self, what: str, hint: str = "") -> None:
        """Report that something is missing between the last token and the present one."""
        last = self.i - 1
        if last < 0 or self._reported >= self.i:
            self.say(self.i, f"got {self.shown(self.i)}", what, hint)
            return
        if self._is_cut and self.kinds[self.i] == token.END:
            return
        self._reported = max(self._reported, last)
        line, column = self.positions[last]
        position = Position(line, column + len(self.texts[last]))
        self.say_at(position, f"{what} is missing behind {self.shown(last)}", "", hint)

    def decimal_hint(self) -> str:
        """Return a hint if the present comma is in a decimal fraction, such as 7,4 or 1,64e9."""
        before, behind = self.kinds[self.i - 1], self.kinds[self.i + 1 : self.i + 2]
        if self.kinds[self.i] != "," or before != token.INTEGER or behind not in ([token.INTEGER], [token.REAL]):
            return ""
        return f"A decimal fraction is written with a point: {self.texts[self.i - 1]}.{self.texts[self.i + 1]}."

    # ---- tokens

    def accept(self, kind: str) -> bool:
        if self.kinds[self.i] == kind:
            self.i += 1
            return True
        return False

    def expect(self, kind: str, hint: str = "") -> None:
        if self.kinds[self.i] != kind:
            raise self.unexpected(kind, hint)
        self.i += 1

    def is_word(self, word: str) -> bool:
        """True if the present token is a word that is a keyword at this place only."""
        return self.kinds[self.i] == token.NAME and self.texts[self.i].upper() == word

    def accept_word(self, word: str) -> bool:
        if self.is_word(word):
            self.i += 1
            return True
        return False

    def expect_word(self, word: str) -> None:
        if not self.accept_word(word):
            raise self.unexpected(word)

    def name(self, what: str) -> str:
        """Read a name; `what` says what it is the name of."""
        if self.kinds[self.i] != token.NAME:
            hint = ""
            if self.texts[self.i][:1].isalpha():
                hint = f"{self.texts[self.i].upper()} is a keyword. Choose another name."
            raise self.unexpected(what, hint)
        self.i += 1
        return self.texts[self.i - 1]

    def quoted(self, what: str) -> str:
        """Read a text in single or double quotes, as it is written; `what` says what it is."""
        if self.kinds[self.i] not in TEXTS:
            raise self.unexpected(f"{what} in quotes")
        self.i += 1
        return re.sub(r"\$(['\"$])", r"\1", self.texts[self.i - 1][1:-1])

    def is_next_line(self) -> bool:
        """True if the present token is in another line than the one before it."""
        return self.i == 0 or self.positions[self.i].line != self.positions[self.i - 1].line

    def is_spaced(self, at: int) -> bool:
        """True if an empty line is in front of a token and its comments."""
        positions = self.positions
        if not at or positions[at].line - positions[at - 1].line < 2:
            return False
        last = self._ends.get(at, positions[at - 1].line)
        comments = self.comments.get(at)
        return (comments[0][0] if comments else positions[at].line) - last > 1

    def is_adjacent(self, at: int) -> bool:
        """True if there is nothing between a token and the one in front of it."""
        line, column = self.positions[at - 1]
        return self.positions[at] == (line, column + len(self.texts[at - 1]))

    def enter(self) -> None:
        """Begin a level of blocks, types or initial values."""
        self.depth += 1
        if self.depth > DEEPEST_BLOCK:
            raise self.too_deep("the program is nested too deeply here", DEEPEST_BLOCK)

    def too_deep(self, what: str, deepest: int) -> UnexpectedError:
        return self._given_up(what, f"at most {deepest} levels")

    def too_long(self, longest: int) -> UnexpectedError:
        return self._given_up("the expression is too long", f"at most {longest} operators in a row")

    def _given_up(self, what: str, expected: str) -> UnexpectedError:
        """Give up the rest of the text, so that one message is enough."""
        self.say(self.i, what, expected)
        self.i = self._reported = len(self.kinds) - 1
        return UnexpectedError()

    # ---- comments

    def gather(self) -> None:
        """Take over the comments in front of the present token."""
        comments = self.comments.pop(self.i, None)
        if comments:
            self._pending += [text for _, text in comments]

    def gather_from(self, first: int) -> None:
        """Take over the comments between a token and the present one."""
        if self.comments:
            for at in range(first, self.i):
                comments = self.comments.pop(at, None)
                if comments:
                    self._pending += [text for _, text in comments]

    def taken(self) -> tuple[str, ...]:
        """Return the gathered comments, for the statement that they belong to."""
        if not self._pending:
            return ()
        comments, self._pending = tuple(self._pending), []
        return comments

    def remark(self) -> str:
        """Return the comments behind the last token, in its line."""
        comments = self.comments.get(self.i)
        if not comments or self.i == 0:
            return ""
        line = self.positions[self.i - 1].line
        remarks = [text for begin, text in comments if begin == line]
        rest = [(begin, text) for begin, text in comments if begin != line]
        if rest:
            self.comments[self.i] = rest
        else:
            del self.comments[self.i]
        self._ends[self.i] = line + sum(text.count("\n") for text in remarks)
        return " ".join(remarks)
