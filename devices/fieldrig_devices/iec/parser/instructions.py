"""Bodies in Instruction List: one instruction in each line.

Source: PacDrive manual 1264 to 1363 and the examples of 2010 to 2813.  An instruction may follow a closing bracket in
the same line (1362), and the arguments of CAL may go over several lines.
"""

import re
from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.instructions import BRACKETS, SPELLINGS, SYMBOLS
from fieldrig_devices.iec.parser.blocks import OUTER
from fieldrig_devices.iec.parser.cursor import UnexpectedError
from fieldrig_devices.iec.parser.statements import Statements

_KEYWORDS: Final = frozenset({"AND", "OR", "XOR", "MOD", "NOT", "&"})
_GLUED: Final = re.compile(f"({'|'.join(sorted(SPELLINGS, key=len, reverse=True))})([0-9]+#\\w+)", re.IGNORECASE)
_NO_OPERATOR: Final = frozenset({":=", "=", ".", "[", "^", ";", ":", "=>", "("})
"""Tokens that follow a name in ST."""


class Instructions(Statements):
    """Reads Instruction List."""

    def begins_with_instruction(self) -> bool:
        """True if the text from the present token on is IL: a line with an operator, perhaps behind labels."""
        return self._is_instruction(self.i)

    def is_instruction_list(self) -> bool:
        """True if the body from the present token on is IL.

        Its first lines may also be functions with their arguments in brackets: a line of IL follows, and no semicolon.
        """
        i = self._behind_labels(self.i)
        while self.kinds[i] == token.NAME and self.kinds[i + 1] == "(":
            closing = self._closing(i + 1)
            if closing is None or self.positions[closing + 1].line == self.positions[closing].line:
                break
            i = self._behind_labels(closing + 1)
        return self._is_instruction(i if self.kinds[i] not in OUTER else self.i)

    def _is_instruction(self, start: int) -> bool:
        i = self._behind_labels(start)
        if self.kinds[i] in OUTER:
            return i > start
        if self.kinds[i] in _KEYWORDS or self._glued(i) is not None:
            return True
        if self.kinds[i] != token.NAME or self.texts[i].upper() not in SPELLINGS:
            return False
        if self.positions[i + 1].line != self.positions[i].line:
            return self.kinds[i + 1] not in (":=", "=")
        if self.kinds[i + 1] in _NO_OPERATOR:
            return False
        return self.kinds[i + 1] == token.END or self.kinds[i + 2] not in (";", "=")

    def _behind_labels(self, i: int) -> int:
        while self.kinds[i] == token.NAME and self.kinds[i + 1] == ":":
            i += 2
        return i

    def _closing(self, at: int) -> int | None:
        """Return the place of the bracket that closes the one at `at`; None if no bracket does before a semicolon."""
        height = 0
        while self.kinds[at] not in OUTER and self.kinds[at] != ";":
            height += (self.kinds[at] == "(") - (self.kinds[at] == ")")
            if height == 0:
                return at
            at += 1
        return None

    def _glued(self, at: int) -> re.Match[str] | None:
        """Return the operator and the number of a token such as LD2#1001, which lacks a blank (manual 2218)."""
        return _GLUED.fullmatch(self.texts[at]) if self.kinds[at] == token.TYPED else None

    def instructions(self, is_deferred: bool = False) -> tuple[tree.IlInstruction, ...]:
        """Read lines up to the end of the body, or to a closing bracket."""
        lines: list[tree.IlInstruction] = []
        while True:
            at = self.i
            is_spaced = self.is_spaced(at)
            self.gather()
            if self.kinds[at] in OUTER or (is_deferred and self.kinds[at] == ")"):
                break
            front = self.taken()
            try:
                instruction = self._instruction()
            except UnexpectedError:
                self._next_line(at)
                self._pending[:0] = front
                continue
            self.gather_from(at)
            instruction.comments = front + self.taken()
            instruction.remark, instruction.is_spaced = self.remark(), is_spaced
            lines.append(instruction)
        if lines and self.kinds[self.i] not in ("ACTION", "METHOD"):  # which has the comments in front of it itself
            lines[-1].after += self.taken()
        return tuple(lines)

    def _next_line(self, start: int) -> None:
        """Go on in the line behind a wrong instruction."""
        if self.i == start and self.kinds[self.i] != token.END:
            self.i += 1
        while not self.is_next_line() and self.kinds[self.i] not in OUTER:
            self.i += 1
        self.gather_from(start)
        self.height = 0

    def _instruction(self) -> tree.IlInstruction:
        at = self.i
        position = self.positions[at]
        label = ""
        if self.kinds[at] == token.NAME and self.kinds[at + 1] == ":":
            label = self.texts[at]
            self.i += 2
            is_label_next = self.kinds[self.i] == token.NAME and self.kinds[self.i + 1] == ":"
            if is_label_next or self.kinds[self.i] in OUTER or self.kinds[self.i] == ")":
                return tree.IlInstruction("", label=label, position=position)
        spelling = self._operator()
        operator, is_negated, is_conditional = SPELLINGS.get(spelling.upper(), (spelling, False, False))
        line = tree.IlInstruction(operator, (), label, is_negated, is_conditional, position=position)
        self._operands(line, self.i - 1)
        self._end_of_line(line)
        return line

    def _operator(self) -> str:
        at = self.i
        if self.kinds[at] == token.NAME or self.kinds[at] in _KEYWORDS:
            self.i += 1
            if self.kinds[self.i] == ":=":
                raise self.unexpected(
                    "an operand", "An assignment in IL is LD value, and ST variable in the next line."
                )
            return self.texts[at]
        glued = self._glued(at)
        if glued is not None:
            hint = f"Write {glued[1].upper()} {glued[2]}, with a blank."
            raise self.unexpected("an operator of IL, such as LD, ST or AND", hint)
        if self.kinds[at] == ")":
            raise self.unexpected("an operator of IL", "There is one closing bracket more than opening ones.")
        raise self.unexpected("an operator of IL, such as LD, ST or AND")

    def _operands(self, line: tree.IlInstruction, at: int) -> None:
        """Read what follows the operator in its line."""
        if self.is_next_line() or self.kinds[self.i] in (")", ";") or self.kinds[self.i] in OUTER:
            return
        is_bracket = self.kinds[self.i] == "("
        has_names = is_bracket and self.kinds[self.i + 1] == token.NAME and self.kinds[self.i + 2] in (":=", "=>")
        if is_bracket and line.operator in BRACKETS and (line.is_negated or not has_names):
            line.deferred = self._deferred()
        elif line.operator == "CAL":
            line.operands = (self._called(),)
        elif line.operator == "JMP":
            line.operands = (tree.Name(self.name("a label"), position=self.positions[self.i - 1]),)
        elif is_bracket and line.operator not in ("LD", "ST", "S", "R", "NOT", "RET"):
            name = tree.Name(line.operator, position=self.positions[at])
            line.operator = "LD"
            line.operands = (tree.Call(name, self.arguments(), position=self.positions[at]),)
        else:
            operands = [self._operand()]
            while self.accept(","):
                operands.append(self._operand())
            line.operands = tuple(operands)

    def _operand(self) -> tree.Expression:
        return self._unary()

    def _called(self) -> tree.Expression:
        if self.kinds[self.i] != token.NAME:
            raise self.unexpected("an instance, a program or an action")
        position = self.positions[self.i]
        called = self.place_or_call()
        return called if isinstance(called, tree.Call) else tree.Call(called, (), position=position)

    def _deferred(self) -> tuple[tree.IlInstruction, ...]:
        """Read the lines in brackets; an operand behind the opening bracket is loaded first."""
        opening = self.i
        self.enter()
        self.i += 1
        first: tuple[tree.IlInstruction, ...] = ()
        if not self.is_next_line() and self.kinds[self.i] != ")" and not self.begins_with_instruction():
            position = self.positions[self.i]
            load = tree.IlInstruction("LD", (self._operand(),), position=position)
            load.remark = self.remark()
            first = (load,)
            if not self.is_next_line() and self.kinds[self.i] != ")":
                raise self.unexpected("the end of the line, or )")
        lines = first + self.instructions(is_deferred=True)
        self.close(")", opening)
        self.depth -= 1
        return lines

    def _end_of_line(self, line: tree.IlInstruction) -> None:
        kind = self.kinds[self.i]
        if kind == ";":
            self.say(self.i, "got ;", "the end of the line", "A line of IL ends without a semicolon.")
            self.i += 1
        elif line.deferred is None and not self.is_next_line() and kind not in OUTER and kind != ")":
            hint = "Operands are separated by commas." if line.operands else ""
            raise self.unexpected("the end of the line", hint)

    # ---- conditions

    def condition_in_il(self) -> tree.Expression:
        """Read IL whose accumulator at the end is the condition of a transition, as an expression."""
        at = self.i
        condition = self._folded(self.instructions())
        if condition is None:
            self.say(at, "the condition has no result", "LD in the first line")
            return tree.Literal(tree.LiteralKind.BOOL, True, "TRUE")
        return condition

    def _folded(self, lines: tuple[tree.IlInstruction, ...]) -> tree.Expression | None:
        accumulator: tree.Expression | None = None
        for line in lines:
            accumulator = self._step(accumulator, line)
        return accumulator

    def _step(self, accumulator: tree.Expression | None, line: tree.IlInstruction) -> tree.Expression | None:
        operands = list(line.operands)
        if line.deferred is not None:
            inner = self._folded(line.deferred)
            operands = [inner] if inner is not None else []
        if line.is_negated:
            operands = [tree.Unary("NOT", operand, position=line.position) for operand in operands]
        if line.operator == "LD" and len(operands) == 1:
            return operands[0]
        if accumulator is not None and line.operator == "NOT" and not operands:
            return tree.Unary("NOT", accumulator, position=line.position)
        if accumulator is not None and line.operator in SYMBOLS and operands:
            for operand in operands:
                accumulator = tree.Binary(SYMBOLS[line.operator], accumulator, operand, position=line.position)
            return accumulator
        if accumulator is not None and line.operator not in SPELLINGS:
            arguments = tuple(tree.Argument(operand) for operand in (accumulator, *operands))
            return tree.Call(tree.Name(line.operator, position=line.position), arguments, position=line.position)
        self.say_at(line.position, f"{line.operator} cannot be in a condition", "LD, AND, OR and the like")
        return accumulator
