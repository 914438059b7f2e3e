"""Statements of Structured Text, with the recovery that finds all mistakes of a text.

Source: PacDrive manual 1365 to 1707.  After a mistake in a statement the parser goes on behind its semicolon or at the
next keyword that begins or ends a statement; the header of a loop or IF goes on behind its THEN, DO or OF.  A semicolon
behind END_IF and the like may be left out, as the manual does at 1256 and 1483.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.parser.cursor import UnexpectedError
from fieldrig_devices.iec.parser.expressions import RANKS, Expressions

Statements_ = tuple[tree.AnyStatement, ...]

_OUTER_TEXT = """
    PROGRAM END_PROGRAM FUNCTION END_FUNCTION FUNCTION_BLOCK END_FUNCTION_BLOCK TYPE END_TYPE ACTION END_ACTION
    CONFIGURATION END_CONFIGURATION RESOURCE END_RESOURCE VAR VAR_INPUT VAR_OUTPUT VAR_IN_OUT VAR_TEMP VAR_EXTERNAL
    VAR_GLOBAL VAR_CONFIG VAR_ACCESS END_VAR INITIAL_STEP END_STEP TRANSITION END_TRANSITION END_ENTRY END_ACTIVE
    END_EXIT END_STRUCT STRUCT
    """
OUTER: Final = frozenset(_OUTER_TEXT.split()) | {token.END}
"""Tokens that cannot occur among statements: the body ends here."""
_BLOCK_ENDS: Final = frozenset({"ELSIF", "ELSE", "END_IF", "END_CASE", "END_FOR", "END_WHILE", "UNTIL", "END_REPEAT"})
_STARTS: Final = frozenset({"IF", "CASE", "FOR", "WHILE", "REPEAT", "EXIT", "RETURN", "CONTINUE"})
_STOPS: Final = OUTER | _BLOCK_ENDS | _STARTS
_OPENERS: Final[Mapping[str, str]] = {
    "END_IF": "IF",
    "ELSIF": "IF",
    "ELSE": "IF or CASE",
    "END_CASE": "CASE",
    "END_FOR": "FOR",
    "END_WHILE": "WHILE",
    "UNTIL": "REPEAT",
    "END_REPEAT": "REPEAT",
}
_NO_OPERATOR: Final = max(RANKS.values()) + 1
_ALWAYS: Final = tree.Literal(tree.LiteralKind.BOOL, True, "TRUE")
"""Stands for a condition that could not be read."""


class Statements(Expressions):
    """Reads statements of ST."""

    def __init__(self, found: token.Tokens, file: str, dialect: Dialect) -> None:
        super().__init__(found, file, dialect)
        self._open: list[frozenset[str]] = []
        """The tokens that continue or end each statement that is open, from the outside to the inside."""
        self._handlers: dict[str, Callable[[], tree.AnyStatement | None]] = {
            token.NAME: self._simple,
            token.DIRECT: self._simple,
            "IF": self._if,
            "CASE": self._case,
            "FOR": self._for,
            "WHILE": self._while,
            "REPEAT": self._repeat,
            "RETURN": self._return,
            "EXIT": self._exit,
            "CONTINUE": self._continue,
            ";": self._empty,
        }

    # ---- blocks

    def statements(self, is_case: bool = False) -> Statements_:
        """Read statements up to a token that ends the block; in a CASE, also up to the next label."""
        found: list[tree.AnyStatement] = []
        kinds, handlers, comments = self.kinds, self._handlers, self.comments
        while True:
            at = self.i
            kind = kinds[at]
            is_spaced = self.is_spaced(at)
            if at in comments:
                self.gather()
            if kind in OUTER or (kind in _BLOCK_ENDS and self._ends_block(kind)):
                break
            if is_case and self._is_case_label():
                return tuple(found)
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
            found.append(statement)
        if self._pending and found:
            found[-1].after += self.taken()
        return tuple(found)

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
        if kind in _BLOCK_ENDS:
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
        raise self.unexpected("a statement", hint)

    def _synchronise(self, start: int) -> None:
        """Go on behind the semicolon of a wrong statement, or at a keyword that begins or ends a statement."""
        if self.i == start and self.kinds[self.i] != token.END:
            self.i += 1
        kinds = self.kinds
        while kinds[self.i] not in _STOPS:
            self.i += 1
            if kinds[self.i - 1] == ";":
                break
        self.gather_from(start)
        self.height = 0

    def _skip_to(self, word: str) -> bool:
        """Skip to a keyword of the header of a statement and behind it.  False if it does not come in this header."""
        kinds = self.kinds
        i = self.i
        while kinds[i] not in _STOPS and kinds[i] != ";":
            if kinds[i] == word:
                self.i = i + 1
                return True
            i += 1
        return False

    def _block(self, ends: frozenset[str], is_case: bool = False) -> Statements_:
        self.enter()
        self._open.append(ends)
        try:
            return self.statements(is_case)
        finally:
            self._open.pop()
            self.depth -= 1

    def _end(self, word: str, opening: int, opener: str, has_semicolon: bool = True) -> None:
        """Read END_IF or the like; report it with the line of its beginning if it is missing."""
        if self.kinds[self.i] == word:
            self.i += 1
            if has_semicolon and self.kinds[self.i] == ";":
                self.i += 1
            return
        line, _ = self.places[opening]
        self.say(self.i, f"got {self.shown(self.i)}", f"{word} for the {opener} in line {line}")

    # ---- headers

    def _condition(self, word: str) -> tree.Expression:
        """Read the condition of a header up to THEN, DO or OF."""
        try:
            found = self.expression()
            found = self._no_assignment(found)
        except UnexpectedError:
            self.height = 0
            if not self._skip_to(word):
                self._after_header()
            return _ALWAYS
        self._header_word(word)
        return found

    def _no_assignment(self, left: tree.Expression) -> tree.Expression:
        """Report := in a condition, and read it as the comparison that was meant."""
        if self.kinds[self.i] != ":=":
            return left
        hint = "A comparison is written with =, an assignment with :=."
        self.say(self.i, "got := in a condition", "=", hint)
        self.i += 1
        return tree.Binary("=", left, self.expression())

    def _header_word(self, word: str) -> None:
        if self.kinds[self.i] == word:
            self.i += 1
            return
        kind = self.kinds[self.i]
        if self._begins_assignment() and not self.is_next_line():
            self.missing(word)
        elif self.is_next_line() or kind in _STOPS or kind == ";":
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
        if self.texts[self.i] == "=" or self.kinds[self.i] == token.NAME:
            return "Between two operands stands an operator, such as AND, OR, = or <>."
        return ""

    def _after_header(self) -> None:
        """Go on in a header that has no THEN, DO or OF: at the next line or behind the semicolon."""
        kinds = self.kinds
        line = self.places[max(self.i - 1, 0)].line
        while kinds[self.i] not in _STOPS and self.places[self.i].line == line:
            self.i += 1
            if kinds[self.i - 1] == ";":
                return

    def _begins_assignment(self) -> bool:
        """True if the present token could begin a statement."""
        return self.kinds[self.i] == token.NAME and self.kinds[self.i + 1] in (":=", ".", "[", "(", "^")

    # ---- statements

    def semicolon(self) -> None:
        """Read the semicolon of a statement."""
        if self.kinds[self.i] == ";":
            self.i += 1
            return
        kind = self.kinds[self.i]
        if self.is_next_line() or kind in _STOPS or self._begins_assignment():
            self.missing(";")
        elif kind == "," and self.kinds[self.i - 1] == token.INTEGER and self.kinds[self.i + 1] == token.INTEGER:
            number = f"{self.texts[self.i - 1]}.{self.texts[self.i + 1]}"
            raise self.unexpected(";", f"A decimal fraction is written with a point: {number}.")
        elif kind == ")":
            raise self.unexpected(";", "There is one closing bracket more than opening ones.")
        elif kind == ":=":
            raise self.unexpected(";", "A statement assigns to one variable only, and a comparison is written with =.")
        elif kind == token.NAME:
            raise self.unexpected(";", "Between two operands stands an operator. A name has no blank in it.")
        else:
            raise self.unexpected(";")

    def _simple(self) -> tree.AnyStatement | None:
        """Read an assignment or a call."""
        at = self.i
        place = self.places[at]
        target = self.place_or_call() if self.kinds[at] == token.NAME else self.expression(_NO_OPERATOR)
        kind = self.kinds[self.i]
        if kind == ":=":
            self.i += 1
            value = self.expression()
            if self.kinds[self.i] == ";":
                self.i += 1
            else:
                self.semicolon()
            if isinstance(target, tree.Call):
                self.say(at, "a value is assigned to a call", "a variable in front of :=")
            return tree.Assign(target, value, place=place)
        if isinstance(target, tree.Call) and kind == ";":
            self.i += 1
            return tree.CallStatement(target, place=place)
        return self._unusual(target, at)

    def _unusual(self, target: tree.Expression, at: int) -> tree.AnyStatement | None:
        """Read what else begins with a name: labels, jumps, calls without brackets, and mistakes."""
        place = self.places[at]
        kind = self.kinds[self.i]
        if isinstance(target, tree.Name) and target.text.upper() == "END" and f"END_{kind}" in _BLOCK_ENDS:
            self._end_in_two_words(at, f"END_{kind}")
            return None
        if isinstance(target, tree.Name) and kind == ":":
            self.i += 1
            if not self.dialect.has_jumps_in_st:
                hint = "Use IF or a loop instead of a jump."
                self.say(self.i - 1, f"{target.text}: is a label, which Structured Text does not have", ":=", hint)
            return tree.Label(target.text, place=place)
        if kind == "=":
            self.say(self.i, "got =", ":=", "An assignment is written with :=.")
            self.i += 1
            value = self.expression()
            self.semicolon()
            return tree.Assign(target, value, place=place)
        if kind in ("+=", "-=", "*="):
            raise self.unexpected(":=", f"Write x := x {kind[0]} ... for x {kind} ...")
        if kind == token.NAME and not self.is_next_line():
            return self._two_names(target, at)
        if isinstance(target, tree.Call):
            self.semicolon()
            return tree.CallStatement(target, place=place)
        if isinstance(target, tree.Name | tree.Member) and (kind == ";" or self.is_next_line() or kind in _STOPS):
            return self._bare(target, at)
        raise self.unexpected(":= or a call")

    def _end_in_two_words(self, at: int, word: str) -> None:
        """Report END IF, and read it as END_IF."""
        self.say(at, f"got END {self.texts[self.i]}", word, f"The keyword is {word}.")
        self.kinds[at], self.kinds[self.i] = word, ";"
        self.i = at

    def _bare(self, target: tree.Name | tree.Member, at: int) -> tree.AnyStatement | None:
        if isinstance(target, tree.Name) and target.text.upper() == "CONTINUE" and not self.dialect.has_continue:
            self.say(at, "CONTINUE is not supported", "IF around the rest of the loop")
            self.accept(";")
            return None
        if not self.dialect.allows_calls_without_brackets:
            self.missing(
                "()" if self.kinds[self.i] == ";" else ":= or ()", "A call has brackets, also without arguments."
            )
            self.accept(";")
            return tree.CallStatement(tree.Call(target, (), place=self.places[at]), place=self.places[at])
        self.semicolon()
        return tree.CallStatement(tree.Call(target, (), place=self.places[at]), place=self.places[at])

    def _two_names(self, target: tree.Expression, at: int) -> tree.AnyStatement | None:
        """Read `JMP label;` and `x S= y;`, or report two names in a row."""
        word = self.texts[self.i].upper()
        place = self.places[at]
        if isinstance(target, tree.Name) and target.text.upper() == "JMP":
            if not self.dialect.has_jumps_in_st:
                hint = "Use IF or a loop instead of a jump."
                self.say(at, "JMP is not allowed in Structured Text", "another statement", hint)
            self.i += 1
            label = self.texts[self.i - 1]
            self.semicolon()
            return tree.Jump(label, place=place)
        if word in ("S", "R") and self.kinds[self.i + 1] == "=" and self.is_adjacent(self.i + 1):
            if not self.dialect.has_set_assignments:
                value = "TRUE" if word == "S" else "FALSE"
                self.say(self.i, f"got {word}=", ":=", f"Write IF condition THEN x := {value}; END_IF.")
            self.i += 2
            value_read = self.expression()
            self.semicolon()
            kind = tree.AssignKind.SET if word == "S" else tree.AssignKind.RESET
            return tree.Assign(target, value_read, kind, place=place)
        hint = ""
        if isinstance(target, tree.Name):
            hint = f"A name has no blank in it: {target.text}_{self.texts[self.i]}."
        raise self.unexpected(":= or a call", hint)

    def _if(self) -> tree.If:
        opening = self.i
        ends = frozenset({"ELSIF", "ELSE", "END_IF"})
        branches = [self._branch(ends)]
        while self.kinds[self.i] == "ELSIF":
            branches.append(self._branch(ends))
        otherwise = None
        if self.accept("ELSE"):
            otherwise = self._block(frozenset({"END_IF"}))
        self._end("END_IF", opening, "IF")
        return tree.If(tuple(branches), otherwise, place=self.places[opening])

    def _branch(self, ends: frozenset[str]) -> tree.Branch:
        place = self.places[self.i]
        self.i += 1
        condition = self._condition("THEN")
        return tree.Branch(condition, self._block(ends), place=place)

    def _while(self) -> tree.While:
        opening = self.i
        self.i += 1
        condition = self._condition("DO")
        body = self._block(frozenset({"END_WHILE"}))
        self._end("END_WHILE", opening, "WHILE")
        return tree.While(condition, body, place=self.places[opening])

    def _repeat(self) -> tree.Repeat:
        opening = self.i
        self.i += 1
        body = self._block(frozenset({"UNTIL", "END_REPEAT"}))
        until: tree.Expression = _ALWAYS
        if self.kinds[self.i] == "UNTIL":
            self.i += 1
            try:
                until = self._no_assignment(self.expression())
                self.accept(";")
            except UnexpectedError:
                self.height = 0
                while self.kinds[self.i] not in _STOPS:
                    self.i += 1
        elif self.kinds[self.i] == "END_REPEAT":
            line = self.places[opening].line
            self.say(self.i, "got END_REPEAT", f"UNTIL condition for the REPEAT in line {line}")
        self._end("END_REPEAT", opening, "REPEAT")
        return tree.Repeat(body, until, place=self.places[opening])

    def _for(self) -> tree.For:
        opening = self.i
        self.i += 1
        variable, first, last, step = self._for_header()
        body = self._block(frozenset({"END_FOR"}))
        self._end("END_FOR", opening, "FOR")
        return tree.For(variable, first, last, step, body, place=self.places[opening])

    def _for_header(self) -> tuple[tree.Expression, tree.Expression, tree.Expression, tree.Expression | None]:
        step = None
        try:
            if self.kinds[self.i] != token.NAME:
                raise self.unexpected("the variable of the loop")
            variable = self.place_or_call()
            if self.kinds[self.i] == "=":
                self.say(self.i, "got =", ":=", "An assignment is written with :=.")
                self.i += 1
            else:
                self.expect(":=")
            first = self.expression()
            self.expect("TO")
            last = self.expression()
            if self.accept("BY"):
                step = self.expression()
        except UnexpectedError:
            self.height = 0
            if not self._skip_to("DO"):
                self._after_header()
            return tree.Name(""), _ALWAYS, _ALWAYS, None
        self._header_word("DO")
        return variable, first, last, step

    def _return(self) -> tree.Return:
        at = self.i
        self.i += 1
        self.semicolon()
        return tree.Return(place=self.places[at])

    def _exit(self) -> tree.Exit:
        at = self.i
        self.i += 1
        self.semicolon()
        return tree.Exit(place=self.places[at])

    def _continue(self) -> tree.Continue:
        at = self.i
        self.i += 1
        self.semicolon()
        return tree.Continue(place=self.places[at])

    def _empty(self) -> tree.Empty:
        self.i += 1
        return tree.Empty(place=self.places[self.i - 1])

    # ---- CASE

    def _case(self) -> tree.Case:
        opening = self.i
        self.i += 1
        selector = self._condition("OF")
        ends = frozenset({"ELSE", "END_CASE"})
        branches: list[tree.CaseBranch] = []
        self._orphans(ends)
        while self._is_case_label():
            branches.append(self._case_branch(ends))
        otherwise = None
        if self.accept("ELSE"):
            self.accept(":")
            otherwise = self._block(frozenset({"END_CASE"}))
        self._end("END_CASE", opening, "CASE")
        return tree.Case(selector, tuple(branches), otherwise, place=self.places[opening])

    def _orphans(self, ends: frozenset[str]) -> None:
        """Report statements in front of the first label."""
        kind = self.kinds[self.i]
        if kind in ends or kind in OUTER or kind in _BLOCK_ENDS or self._is_case_label():
            return
        self.say(self.i, f"got {self.shown(self.i)}", "a value with a colon, such as 1:")
        self._block(ends, is_case=True)

    def _is_case_label(self) -> bool:
        kinds = self.kinds
        i = self.i
        if kinds[i] in (token.INTEGER, token.TYPED, "-", token.STRING, token.REAL, "TRUE", "FALSE", "("):
            return True
        if kinds[i] != token.NAME:
            return False
        while kinds[i + 1] == "." and kinds[i + 2] == token.NAME:
            i += 2
        return kinds[i + 1] in (":", ",", "..")

    def _case_branch(self, ends: frozenset[str]) -> tree.CaseBranch:
        at = self.i
        self.gather()
        front = self.taken()
        labels: list[tree.Expression | tree.Range] = []
        try:
            labels.append(self._case_label())
            while self.accept(","):
                labels.append(self._case_label())
            if self.kinds[self.i] == ":=":
                self.say(self.i, "got := behind a value of CASE", ":")
                self.i += 1
            else:
                self.expect(":")
        except UnexpectedError:
            self._synchronise(at)
        body = self._block(ends, is_case=True)
        return tree.CaseBranch(tuple(labels), body, place=self.places[at], comments=front)

    def _case_label(self) -> tree.Expression | tree.Range:
        place = self.places[self.i]
        low = self.expression()
        if self.accept(".."):
            return tree.Range(low, self.expression(), place=place)
        return low
