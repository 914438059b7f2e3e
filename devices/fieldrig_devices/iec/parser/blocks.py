"""Blocks of statements: how they end, how headers are read, and how the parser goes on after a mistake.

After a mistake in a statement the parser goes on behind its semicolon or at the next keyword that begins or ends a
statement.  The header of a loop or IF goes on behind its THEN, DO or OF.  A semicolon behind END_IF and the like may be
left out, as the manual does at 1256 and 1483.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.parser.cursor import UnexpectedError
from fieldrig_devices.iec.parser.expressions import Expressions

Block = tuple[tree.AnyStatement, ...]

_OUTER_TEXT = """
    PROGRAM END_PROGRAM FUNCTION END_FUNCTION FUNCTION_BLOCK END_FUNCTION_BLOCK TYPE END_TYPE ACTION END_ACTION
    CONFIGURATION END_CONFIGURATION RESOURCE END_RESOURCE VAR VAR_INPUT VAR_OUTPUT VAR_IN_OUT VAR_TEMP VAR_STAT VAR_INST
    VAR_GENERIC VAR_EXTERNAL VAR_GLOBAL VAR_CONFIG VAR_ACCESS END_VAR INITIAL_STEP END_STEP TRANSITION
    END_TRANSITION END_ENTRY END_ACTIVE END_EXIT END_STRUCT STRUCT END_UNION UNION METHOD END_METHOD PROPERTY
    END_PROPERTY END_GET END_SET INTERFACE END_INTERFACE CLASS END_CLASS END_TEST END_SETUP END_TEARDOWN
    """
OUTER: Final = frozenset(_OUTER_TEXT.split()) | {token.END}
"""Tokens that cannot occur among statements: the body ends here."""
_BLOCK_END_TEXT = """
    ELSIF ELSE END_IF END_CASE END_FOR END_WHILE UNTIL END_REPEAT __CATCH __FINALLY __ENDTRY
    """
BLOCK_ENDS: Final = frozenset(_BLOCK_END_TEXT.split())
_STARTS: Final = frozenset({"IF", "CASE", "FOR", "WHILE", "REPEAT", "EXIT", "RETURN", "CONTINUE", "__TRY"})
STOPS: Final = OUTER | BLOCK_ENDS | _STARTS
_OPENERS: Final[Mapping[str, str]] = {
    "END_IF": "IF",
    "ELSIF": "IF",
    "ELSE": "IF or CASE",
    "END_CASE": "CASE",
    "END_FOR": "FOR",
    "END_WHILE": "WHILE",
    "UNTIL": "REPEAT",
    "END_REPEAT": "REPEAT",
    **dict.fromkeys(("__CATCH", "__FINALLY", "__ENDTRY"), "__TRY"),
}
_CONSTANTS: Final = frozenset(
    {token.INTEGER, token.REAL, token.STRING, token.WIDE_STRING, token.TYPED, "-", "(", "TRUE", "FALSE"}
)
"""Tokens that begin a label of CASE, besides names; a label of another type gets its message from the checker."""
OPERANDS: Final = _CONSTANTS | {token.NAME, token.DIRECT, "NOT"}
"""Tokens that begin an operand."""
ALWAYS: Final = tree.Literal(tree.LiteralKind.BOOL, True, "TRUE")
"""Stands for a condition that could not be read."""


class Blocks(Expressions):
    """Reads blocks; the statements in them are read by the handlers that `Statements` adds."""

    def __init__(self, tokens: token.Tokens, file: str, dialect: Dialect) -> None:
        super().__init__(tokens, file, dialect)
        self._is_label_spaced = False
        """True if an empty line precedes the present label of a CASE."""
        self._open: list[frozenset[str]] = []
        """The tokens that continue or end each statement that is open, from the outside to the inside."""
        self._closed: list[tuple[int, int]] = []
        """The first and last token of each statement that has its end."""
        self._handlers: dict[str, Callable[[], tree.AnyStatement | None]] = {}

    # ---- blocks

    def statements(self, is_case: bool = False) -> Block:
        """Read statements up to a token that ends the block; in a CASE, also up to the next label."""
        block: list[tree.AnyStatement] = []
        kinds, handlers, comments = self.kinds, self._handlers, self.comments
        while True:
            at = self.i
            kind = kinds[at]
            is_spaced = self.is_spaced(at)
            if at in comments:
                self.gather()
            if kind in OUTER or (kind in BLOCK_ENDS and self._ends_block(kind)):
                break
            if is_case and self._is_case_label():
                self._is_label_spaced = is_spaced
                return tuple(block)
            handler = handlers.get(kind)
            front = self.taken() if self._pending else ()
            try:
                statement = handler() if handler is not None else self._wrong_start(kind)
            except UnexpectedError:
                self._synchronise(at)
                statement = None
            if statement is None:
                self._pending[:0] = front
                continue
            if is_spaced:
                statement.is_spaced = True
            if comments or front or self._pending:
                self._decorate(statement, front, at)
            block.append(statement)
        has_own_comments = self.kinds[self.i] in ("ACTION", "METHOD")
        if self._pending and block and not has_own_comments:
            block[-1].after += self.taken()
        return tuple(block)

    def _decorate(self, statement: tree.AnyStatement, front: tuple[str, ...], at: int) -> None:
        """Give a statement its comments: those in front, those inside that no inner one has, and one behind."""
        self.gather_from(at)
        statement.comments = front + self.taken()
        if self.i in self.comments:
            statement.remark = self.remark()

    def _ends_block(self, kind: str) -> bool:
        """True if an END_IF or the like belongs to an open statement; otherwise it is reported and skipped later."""
        return any(kind in ends for ends in self._open)

    def _wrong_start(self, kind: str) -> tree.AnyStatement | None:
        """Report a token that begins no statement."""
        if kind in BLOCK_ENDS:
            opener = _OPENERS[kind]
            self.say(self.i, f"got {self.shown(self.i)}, but no {opener} is open here", f"{opener} in front of it")
            self.i += 1
            if kind in ("ELSIF", "UNTIL"):
                self._skip_to("THEN" if kind == "ELSIF" else ";")
            self.accept(";")
            return None
        if kind in ("END_VAR", token.NATIVE):
            raise self.unexpected("a statement")
        hint = ""
        if kind in ("AND", "OR", "XOR", "MOD", "NOT") or kind in token.KEYWORDS:
            hint = f"{kind} is a keyword."
        elif kind in ("+", "-") and self.kinds[self.i + 1] == kind:
            hint = f"Write x := x {kind} 1 for {kind}{kind}x."
        raise self.unexpected("a statement", hint)

    def _synchronise(self, start: int) -> None:
        """Go on behind the semicolon of a wrong statement, or at a keyword that begins or ends a statement."""
        if self.i == start and self.kinds[self.i] != token.END:
            self.i += 1
        kinds = self.kinds
        while kinds[self.i] not in STOPS:
            self.i += 1
            if kinds[self.i - 1] == ";":
                break
        self.gather_from(start)
        self.height = 0

    def _skip_to(self, word: str) -> bool:
        """Skip to a keyword of the header of a statement and behind it.  False if it does not come in this header."""
        kinds = self.kinds
        i = self.i
        while kinds[i] not in STOPS and kinds[i] != ";":
            if kinds[i] == word:
                self.i = i + 1
                return True
            i += 1
        return False

    def _block(self, ends: frozenset[str], is_case: bool = False) -> Block:
        self.enter()
        self._open.append(ends)
        try:
            return self.statements(is_case)
        finally:
            self._open.pop()
            self.depth -= 1

    def _end(self, word: str, opening: int, opener: str, has_semicolon: bool = True, hint: str = "") -> None:
        """Read END_IF or the like; report it with the line of its beginning if it is missing."""
        if self.kinds[self.i] == word:
            self._closed.append((opening, self.i))
            self.i += 1
            if has_semicolon and self.kinds[self.i] == ";":
                self.i += 1
            return
        line, _ = self.positions[opening]
        expected = f"{word} for the {opener} in line {line}"
        self.say(self.i, f"got {self.shown(self.i)}", expected, hint or self._suspect(opening))

    def _suspect(self, opening: int) -> str:
        """Return a hint which statement inside lacks its end, if the indentation shows it."""
        column = self.positions[opening].column
        for inner, end in self._closed:
            first, last = self.positions[inner], self.positions[end]
            if inner > opening and first.line != last.line and first.column > column == last.column:
                word = self.texts[inner]
                seen = f"see the indentation of line {last.line}."
                return f"{word} in line {first.line} may lack its {self.kinds[end]}: {seen}"
        return ""

    # ---- headers

    def _condition(self, word: str) -> tree.Expression:
        """Read the condition of a header up to THEN, DO or OF."""
        try:
            condition = self.expression()
            condition = self._no_assignment(condition)
        except UnexpectedError:
            self.height = 0
            if not self._skip_to(word):
                self._after_header()
            return ALWAYS
        self._header_word(word)
        return condition

    def _no_assignment(self, left: tree.Expression) -> tree.Expression:
        """Report := in a condition, unless it may assign there, and read it as the comparison that was meant."""
        left = self.assigned(left)
        if self.kinds[self.i] != ":=":
            return left
        hint = "A comparison is written with =, an assignment with :=."
        position = self.positions[self.i]
        self.say(self.i, "got := in a condition", "=", hint)
        self.i += 1
        return tree.Binary("=", left, self.expression(), position=position)

    def _header_word(self, word: str) -> None:
        if self.kinds[self.i] == word:
            self.i += 1
            return
        kind = self.kinds[self.i]
        if self._begins_assignment() and not self.is_next_line():
            self.missing(word)
        elif self.is_next_line() or kind in STOPS or kind == ";":
            self.missing(word)
            self._after_header()
        elif kind in ("THEN", "DO", "OF"):
            self.say(self.i, f"got {kind}", word)
            self.i += 1
        else:
            self.say(self.i, f"got {self.shown(self.i)}", word, self._operator_hint())
            if not self._skip_to(word):
                self._after_header()

    def _operator_hint(self) -> str:
        if self.kinds[self.i] == ")":
            return "There is one closing bracket more than opening ones."
        if self.texts[self.i].upper() == "STEP":
            return "The step of a FOR is behind BY."
        if self.texts[self.i] == "=" or self.kinds[self.i] == token.NAME:
            return "Between two operands stands an operator, such as AND, OR, = or <>."
        return ""

    def _after_header(self) -> None:
        """Go on in a header that has no THEN, DO or OF: at the next line or behind the semicolon."""
        kinds = self.kinds
        line = self.positions[max(self.i - 1, 0)].line
        while kinds[self.i] not in STOPS and self.positions[self.i].line == line:
            self.i += 1
            if kinds[self.i - 1] == ";":
                return

    def _begins_assignment(self) -> bool:
        """True if the present token could begin a statement."""
        return self.kinds[self.i] == token.NAME and self.kinds[self.i + 1] in (":=", ".", "[", "(", "^")

    def _is_word_case(self) -> bool:
        """True at `case 1:` of other languages."""
        kinds, i = self.kinds, self.i
        return kinds[i] == "CASE" and kinds[i + 1] in (token.INTEGER, token.NAME) and kinds[i + 2] == ":"

    def _is_case_label(self) -> bool:
        kinds = self.kinds
        i = self.i
        if kinds[i] in _CONSTANTS or self._is_word_case():
            return True
        if kinds[i] != token.NAME:
            return False
        while kinds[i + 1] == "." and kinds[i + 2] == token.NAME:
            i += 2
        return kinds[i + 1] in (":", ",", "..")
