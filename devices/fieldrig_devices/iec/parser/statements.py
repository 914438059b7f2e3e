"""Statements of Structured Text, and what is read in their place after a mistake.

Source: PacDrive manual 1365 to 1707.
"""

from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.elementary import ALIASES, Elementary
from fieldrig_devices.iec.parser.blocks import ALWAYS, BLOCK_ENDS, OPERANDS, OUTER, STOPS, Blocks
from fieldrig_devices.iec.parser.cursor import UnexpectedError
from fieldrig_devices.iec.parser.expressions import RANKS

_NO_OPERATOR: Final = max(RANKS.values()) + 1
_MOCKS: Final = frozenset({"MOCK", "MOCK_FUNCTION"})
_OBJECT_ORIENTED: Final = frozenset({"METHOD", "PROPERTY"})


_TYPES: Final = frozenset({*map(str, Elementary), *ALIASES})
OTHER_DIALECTS: Final = "The dialects codesys and edition-3 have it: --dialect codesys"
"""The hint for what programs of other systems have."""
_WORDS: Final = {
    "GOTO": "Structured Text has loops, IF and CASE instead of jumps.",
    "LET": "An assignment is x := 5; without a word in front.",
    "MOVE": "An assignment is x := y; or x := MOVE(y);",
    "CALL": "A call is the name of the instance with brackets: timer(IN := x);",
    "CAL": "A call is the name of the instance with brackets: timer(IN := x);",
}
"""Words with which statements of other languages begin."""


class Statements(Blocks):
    """Reads statements of ST."""

    def __init__(self, tokens: token.Tokens, file: str, dialect: Dialect) -> None:
        super().__init__(tokens, file, dialect)
        self._handlers |= {
            token.NAME: self._simple,
            token.DIRECT: self._simple,
            "IF": self._if,
            "CASE": self._case,
            "FOR": self._for,
            "WHILE": self._while,
            "REPEAT": self._repeat,
            "__TRY": self._try,
            "RETURN": self._return,
            "EXIT": self._exit,
            "CONTINUE": self._continue,
            ";": self._empty,
        }

    # ---- statements

    def semicolon(self) -> None:
        """Read the semicolon of a statement."""
        if self.kinds[self.i] == ";":
            self.i += 1
            return
        kind = self.kinds[self.i]
        if self.is_next_line() or kind in STOPS or self._begins_assignment():
            self.missing(";")
        elif kind == ",":
            raise self.unexpected(";", self.decimal_hint())
        elif kind == ")":
            raise self.unexpected(";", "There is one closing bracket more than opening ones.")
        elif kind == ":=":
            raise self.unexpected(";", "A statement assigns to one variable only, and a comparison is written with =.")
        elif kind == token.NAME:
            raise self.unexpected(";", "Between two operands stands an operator. A name has no blank in it.")
        elif kind == "=>":
            raise self.unexpected(";", "The sign for greater or equal is >=.")
        else:
            raise self.unexpected(";")

    def _simple(self) -> tree.AnyStatement | None:
        """Read an assignment or a call."""
        at = self.i
        position = self.positions[at]
        target = self.place_or_call() if self.kinds[at] == token.NAME else self.expression(_NO_OPERATOR)
        kind = self.kinds[self.i]
        if kind == ":=":
            self.i += 1
            value = self.expression()
            others: tuple[tree.Expression, ...] = ()
            if self.kinds[self.i] == ":=" and self.dialect.has_chained_assignments:
                value, others = self._chained(value)
            if self.kinds[self.i] == ";":
                self.i += 1
            else:
                self.semicolon()
            if isinstance(target, tree.Call):
                hint = f"An element of an array is {self.shown(at)}[...], in square brackets."
                self.say(at, "a value is assigned to a call", "a variable in front of :=", hint)
                target = tree.Name("", position=position)
            return tree.Assign(target, value, others=others, position=position)
        if isinstance(target, tree.Call) and kind == ";":
            self.i += 1
            return tree.CallStatement(target, position=position)
        return self._unusual(target, at)

    def _chained(self, value: tree.Expression) -> tuple[tree.Expression, tuple[tree.Expression, ...]]:
        """Read the rest of `a := b := 3` behind b; return the value and the further targets."""
        others: list[tree.Expression] = []
        while self.accept(":="):
            others.append(value)
            value = self.expression()
        return value, tuple(others)

    def _unusual(self, target: tree.Expression, at: int) -> tree.AnyStatement | None:
        """Read what else begins with a name: labels, jumps, calls without brackets, and mistakes."""
        position = self.positions[at]
        kind = self.kinds[self.i]
        if isinstance(target, tree.Name) and target.text.upper() == "END" and f"END_{kind}" in BLOCK_ENDS:
            self._end_in_two_words(at, f"END_{kind}")
            return None
        if isinstance(target, tree.Name) and kind == ":":
            self.i += 1
            if not self.dialect.has_jumps_in_st:
                hint = "Use IF or a loop instead of a jump."
                self.say(self.i - 1, f"{target.text}: is a label, which Structured Text does not have", ":=", hint)
            return tree.Label(target.text, position=position)
        if kind == "=":
            self.say(self.i, "got =", ":=", "An assignment is written with :=.")
            self.i += 1
            value = self.expression()
            self.semicolon()
            return tree.Assign(target, value, position=position)
        if kind == "?=":
            return self._attempt(target, at)
        if kind in ("+=", "-=", "*="):
            raise self.unexpected(":=", f"Write x := x {kind[0]} ... for x {kind} ...")
        if kind in ("+", "-") and self.kinds[self.i + 1] == kind:
            raise self.unexpected(":= or a call", f"Write x := x {kind} 1 for x{kind}{kind}.")
        if kind == token.NAME and not self.is_next_line():
            return self._two_names(target, at)
        if isinstance(target, tree.Call):
            if self._is_switch(target):
                return self._switch(target, at)
            self.semicolon()
            return tree.CallStatement(target, position=position)
        if isinstance(target, tree.Name | tree.Member) and (kind == ";" or self.is_next_line() or kind in STOPS):
            return self._bare(target, at)
        raise self.unexpected(":= or a call")

    def _is_switch(self, target: tree.Call) -> bool:
        """True for `switch (x)` in front of a `case`, or of a text in braces, which has become a pragma."""
        called = target.called
        is_named = isinstance(called, tree.Name) and called.text.casefold() == "switch"
        is_pragma = any(text.startswith("{") for _, text in self.comments.get(self.i, ()))
        return is_named and len(target.arguments) == 1 and (self._is_word_case() or is_pragma)

    def _switch(self, target: tree.Call, at: int) -> tree.Case | None:
        """Report `switch (x)`, and read its cases as those of CASE."""
        self.say(at, f"got {self.shown(at)}", "CASE", "Write CASE x OF 1: ...; 2: ...; ELSE ...; END_CASE;")
        selector = target.arguments[0].value
        return self._cases(at, selector) if self._is_word_case() and selector is not None else None

    def _attempt(self, target: tree.Expression, at: int) -> tree.Assign:
        """Read `a ?= b;`."""
        if not self.dialect.has_assignment_attempts:
            hint = "The dialect edition-3 has ?=." if self.dialect.has_methods else ""
            raise self.unexpected(":=", hint and f"{hint} Here a ?= b is __QUERYINTERFACE(b, a).")
        self.i += 1
        value = self.expression()
        self.semicolon()
        return tree.Assign(target, value, tree.AssignKind.ATTEMPT, position=self.positions[at])

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
            return tree.CallStatement(tree.Call(target, (), position=self.positions[at]), position=self.positions[at])
        self.semicolon()
        return tree.CallStatement(tree.Call(target, (), position=self.positions[at]), position=self.positions[at])

    def _two_names(self, target: tree.Expression, at: int) -> tree.AnyStatement | None:
        """Read `JMP label;` and `x S= y;`, or report two names in a row."""
        word = self.texts[self.i].upper()
        position = self.positions[at]
        if self.is_test and isinstance(target, tree.Name) and target.text.upper() in _MOCKS:
            return self._mock(target)
        if isinstance(target, tree.Name) and target.text.upper() in _OBJECT_ORIENTED:
            self._skip_object_oriented(at)
            return None
        if isinstance(target, tree.Name) and target.text.upper() == "JMP":
            if not self.dialect.has_jumps_in_st:
                hint = "Use IF or a loop instead of a jump."
                self.say(at, "JMP is not allowed in Structured Text", "another statement", hint)
            self.i += 1
            label = self.texts[self.i - 1]
            self.semicolon()
            return tree.Jump(label, position=position)
        if word in ("S", "R") and self.kinds[self.i + 1] == "=" and self.is_adjacent(self.i + 1):
            if not self.dialect.has_set_assignments:
                value = "TRUE" if word == "S" else "FALSE"
                self.say(self.i, f"got {word}=", ":=", f"Write IF condition THEN x := {value}; END_IF.")
            self.i += 2
            value_read = self.expression()
            self.semicolon()
            kind = tree.AssignKind.SET if word == "S" else tree.AssignKind.RESET
            return tree.Assign(target, value_read, kind, position=position)
        if word == "REF" and self.dialect.has_references and self.kinds[self.i + 1] == "=":
            self.i += 2
            referred = self.expression()
            self.semicolon()
            return tree.Assign(target, referred, tree.AssignKind.REFER, position=position)
        hint = ""
        if isinstance(target, tree.Name):
            name, after = target.text, self.texts[self.i]
            is_test = name.upper().startswith("ASSERT")
            hint = f"Write {name}({after}...);" if is_test else _hint(name.upper(), name, after)
        raise self.unexpected(":= or a call", hint)

    def _mock(self, word: tree.Name) -> tree.CallStatement:
        """Read `MOCK instance;` and `MOCK_FUNCTION F RETURNS value;` as calls."""
        given = [self.place_or_call()]
        if self.accept_word("RETURNS"):
            given.append(self.expression())
        self.semicolon()
        arguments = tuple(tree.Argument(value=value, position=value.position) for value in given)
        return tree.CallStatement(tree.Call(word, arguments, position=word.position), position=word.position)

    def _skip_object_oriented(self, at: int) -> None:
        """Report a method or property, and read on behind it."""
        word = self.texts[at].upper()
        hint = f"Turn it into an ACTION or into a FUNCTION_BLOCK of its own. {OTHER_DIALECTS}"
        self.say(at, f"a {word} is not supported", "a statement", hint)
        while self.kinds[self.i] not in (token.END, "END_FUNCTION_BLOCK", "END_PROGRAM"):
            self.i += 1
            previous = self.texts[self.i - 1].upper()
            if previous == f"END_{word}" or self.texts[self.i].upper() in _OBJECT_ORIENTED:
                break
        self.accept(";")

    def _if(self) -> tree.If:
        opening = self.i
        ends = frozenset({"ELSIF", "ELSE", "END_IF"})
        branches = [self._branch(ends)]
        while self.kinds[self.i] == "ELSIF":
            branches.append(self._branch(ends))
        otherwise = None
        hint = ""
        if self.accept("ELSE"):
            if self.kinds[self.i] == "IF" and not self.is_next_line():
                line = self.positions[self.i].line
                hint = f"ELSE IF in line {line} begins an IF with an END_IF of its own. Write ELSIF."
            otherwise = self._block(frozenset({"END_IF"}))
        self._end("END_IF", opening, "IF", hint=hint)
        return tree.If(tuple(branches), otherwise, position=self.positions[opening])

    def _branch(self, ends: frozenset[str]) -> tree.Branch:
        position = self.positions[self.i]
        self.i += 1
        condition = self._condition("THEN")
        remark = self.remark() if self.i in self.comments and self.is_next_line() else ""
        return tree.Branch(condition, self._block(ends), position=position, remark=remark)

    def _while(self) -> tree.While:
        opening = self.i
        self.i += 1
        condition = self._condition("DO")
        body = self._block(frozenset({"END_WHILE"}))
        self._end("END_WHILE", opening, "WHILE")
        return tree.While(condition, body, position=self.positions[opening])

    def _repeat(self) -> tree.Repeat:
        opening = self.i
        self.i += 1
        body = self._block(frozenset({"UNTIL", "END_REPEAT"}))
        until: tree.Expression = ALWAYS
        if self.kinds[self.i] == "UNTIL":
            self.i += 1
            try:
                until = self._no_assignment(self.expression())
                self.accept(";")
            except UnexpectedError:
                self.height = 0
                while self.kinds[self.i] not in STOPS:
                    self.i += 1
        elif self.kinds[self.i] == "END_REPEAT":
            line = self.positions[opening].line
            self.say(self.i, "got END_REPEAT", f"UNTIL condition for the REPEAT in line {line}")
        self._end("END_REPEAT", opening, "REPEAT")
        return tree.Repeat(body, until, position=self.positions[opening])

    def _try(self) -> tree.Try:
        opening = self.i
        self.i += 1
        body = self._block(frozenset({"__CATCH", "__FINALLY", "__ENDTRY"}))
        code, caught, final = None, None, None
        if self.accept("__CATCH"):
            if self.accept("("):
                code = self.place_or_call()
                self.expect(")")
            caught = self._block(frozenset({"__FINALLY", "__ENDTRY"}))
        if self.accept("__FINALLY"):
            final = self._block(frozenset({"__ENDTRY"}))
        if self.kinds[self.i] == "__ENDTRY" and caught is None and final is None:
            line = self.positions[opening].line
            self.say(self.i, "got __ENDTRY", f"__CATCH or __FINALLY for the __TRY in line {line}")
        self._end("__ENDTRY", opening, "__TRY")
        return tree.Try(body, code, caught, final, position=self.positions[opening])

    def _for(self) -> tree.For | tree.While:
        opening = self.i
        position = self.positions[opening]
        self.i += 1
        header = self._for_header()
        body = self._block(frozenset({"END_FOR"}))
        self._end("END_FOR", opening, "FOR")
        if header is None:  # a loop whose body can be checked
            return tree.While(ALWAYS, body, position=position)
        return tree.For(*header, body, position=position)

    def _for_header(self) -> tuple[tree.Expression, tree.Expression, tree.Expression, tree.Expression | None] | None:
        step = None
        try:
            if self.kinds[self.i] == "(":
                self._for_in_brackets()
                return None
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
            return None
        self._header_word("DO")
        return variable, first, last, step

    def _for_in_brackets(self) -> None:
        """Report the header of another language, `for (i = 0; i < 10; i++)`, and go on behind it."""
        self.say(self.i, "got (", "the variable of the loop", "Write FOR i := 0 TO 9 DO ...; END_FOR;")
        depth = 0
        while self.kinds[self.i] != token.END and self.kinds[self.i] not in BLOCK_ENDS:
            depth += {"(": 1, ")": -1}.get(self.kinds[self.i], 0)
            self.i += 1
            if depth == 0:
                break
        self.accept("DO")

    def _return(self) -> tree.Return:
        at = self.i
        self.i += 1
        if self.kinds[self.i] == "(" and self.dialect.has_conditional_return:
            condition = self.expression()
            self.semicolon()
            return tree.Return(condition, position=self.positions[at])
        if not self.is_next_line() and self.kinds[self.i] in OPERANDS:
            hint = "The result of a function is assigned to its name in front of it: Name := value; RETURN;"
            raise self.unexpected(";", hint)
        self.semicolon()
        return tree.Return(position=self.positions[at])

    def _exit(self) -> tree.Exit:
        at = self.i
        self.i += 1
        self.semicolon()
        return tree.Exit(position=self.positions[at])

    def _continue(self) -> tree.Continue:
        at = self.i
        self.i += 1
        self.semicolon()
        return tree.Continue(position=self.positions[at])

    def _empty(self) -> tree.Empty:
        self.i += 1
        return tree.Empty(position=self.positions[self.i - 1])

    # ---- CASE

    def _case(self) -> tree.Case:
        opening = self.i
        self.i += 1
        return self._cases(opening, self._condition("OF"))

    def _cases(self, opening: int, selector: tree.Expression) -> tree.Case:
        """Read the branches of a CASE, behind its OF."""
        ends = frozenset({"ELSE", "END_CASE"})
        branches: list[tree.CaseBranch] = []
        self._orphans(ends)
        self._is_label_spaced = False
        while self._is_case_label():
            branches.append(self._case_branch(ends))
        otherwise = None
        if self.accept("ELSE"):
            self.accept(":")
            otherwise = self._block(frozenset({"END_CASE"}))
        self._end("END_CASE", opening, "CASE")
        return tree.Case(selector, tuple(branches), otherwise, position=self.positions[opening])

    def _orphans(self, ends: frozenset[str]) -> None:
        """Report statements in front of the first label."""
        kind = self.kinds[self.i]
        if kind in ends or kind in OUTER or kind in BLOCK_ENDS or self._is_case_label():
            return
        self.say(self.i, f"got {self.shown(self.i)}", "a value with a colon, such as 1:")
        self._block(ends, is_case=True)

    def _case_branch(self, ends: frozenset[str]) -> tree.CaseBranch:
        at = self.i
        is_spaced = self._is_label_spaced
        self.gather()
        front = self.taken()
        labels: list[tree.Expression | tree.Range] = []
        if self._is_word_case():
            value = f"{self.shown(at + 1)}:"
            self.say(at, f"got {self.shown(at)}", value, "A branch of CASE begins with its value only.")
            self.i += 1
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
        remark = self.remark() if self.i in self.comments and self.is_next_line() else ""
        body = self._block(ends, is_case=True)
        return tree.CaseBranch(
            tuple(labels), body, position=self.positions[at], comments=front, remark=remark, is_spaced=is_spaced
        )

    def _case_label(self) -> tree.Expression | tree.Range:
        position = self.positions[self.i]
        low = self.expression()
        if self.accept(".."):
            return tree.Range(low, self.expression(), position=position)
        return low


def _hint(word: str, name: str, after: str) -> str:
    """Return what to do about a name, `word` in capitals, with something behind it that neither assigns nor calls."""
    if word in _TYPES:
        return f"A variable is declared between VAR and END_VAR: {after} : {word};"
    if word in _WORDS:
        return _WORDS[word]
    if not after.isidentifier():
        return "The sign of the assignment is :=." if after == "<" else ""
    return f"A name has no blank in it: {name}_{after}."
