"""Bodies of POUs, actions and steps, in the language that their first line shows; and Sequential Function Charts.

A body is SFC if it begins with a step, Instruction List if it begins with a line of IL, and Structured Text otherwise.
The text of SFC is that of IEC 61131-3.  The simple steps of the manual (1725 to 1767), which have actions of their own
instead of named ones, have no text in any standard; theirs is this:

    STEP Fill:
        ENTRY   valve := TRUE;       END_ENTRY     (* once when the step becomes active *)
        ACTIVE  level := level + 1;  END_ACTIVE    (* in each cycle *)
        EXIT    valve := FALSE;      END_EXIT      (* once before it becomes inactive *)
    END_STEP
"""

from typing import Final

from fieldrig_devices.iec import tokens as token
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.parser.blocks import OUTER
from fieldrig_devices.iec.parser.cursor import UnexpectedError
from fieldrig_devices.iec.parser.instructions import Instructions

QUALIFIERS: Final = frozenset({"N", "R", "S", "L", "D", "P", "SD", "DS", "SL", "P0", "P1"})
TIMED: Final = frozenset({"L", "D", "SD", "DS", "SL"})
"""Qualifiers with a time."""


class Bodies(Instructions):
    """Reads bodies."""

    def __init__(self, tokens: token.Tokens, file: str, dialect: Dialect) -> None:
        super().__init__(tokens, file, dialect)
        self.actions: list[tree.Action] = []
        """Actions among the steps of a chart, which belong to its POU."""

    def body(self, language: str = "") -> tree.Body:
        """Read a body up to a token that ends it."""
        position = self.positions[self.i]
        if self.kinds[self.i] == token.NATIVE:
            self.i += 1
            self.accept(";")
            return tree.NativeBody(position=position)
        if language == "SFC" or (not language and self._is_chart()):
            return self._chart(position)
        if language == "IL" or (not language and self.is_instruction_list()):
            return tree.IlBody(self.instructions(), position=position)
        return tree.StBody(self.statements(), position=position)

    # ---- charts

    def _is_chart(self) -> bool:
        return self.kinds[self.i] in ("INITIAL_STEP", "TRANSITION") or self._is_step()

    def _is_step(self) -> bool:
        following = self.i + 1
        if not self.is_word("STEP"):
            return self.kinds[self.i] == "INITIAL_STEP"
        return self.kinds[following] == token.NAME and self.kinds[following + 1] == ":"

    def _chart(self, position: tree.Position) -> tree.SfcBody:
        steps: list[tree.Step] = []
        transitions: list[tree.Transition] = []
        self.enter()
        last: tree.Step | tree.Transition | None = None
        while True:
            at = self.i
            is_spaced = self.is_spaced(at)
            self.gather()
            front = self.taken()
            try:
                if self._is_step():
                    last = self._step_of_chart()
                    steps.append(last)
                elif self.kinds[at] == "TRANSITION":
                    last = self._transition()
                    transitions.append(last)
                elif self.kinds[at] == "ACTION":
                    self._pending[:0] = front
                    self.actions.append(self.action())
                    continue
                elif self.kinds[at] in OUTER:
                    break
                else:
                    raise self.unexpected("STEP, TRANSITION or ACTION")
            except UnexpectedError:
                self._pending[:0] = front
                self._next_part(at)
                continue
            self.gather_from(at)
            last.comments, last.remark, last.is_spaced = front + self.taken(), self.remark(), is_spaced
        self.depth -= 1
        if last is not None and self.kinds[self.i] != "METHOD":  # which has the comments in front of it itself
            last.after = front
        else:
            self._pending[:0] = front
        return tree.SfcBody(tuple(steps), tuple(transitions), position=position)

    def _next_part(self, start: int) -> None:
        """Go on at the next part of the chart."""
        if self.i == start and self.kinds[self.i] != token.END:
            self.i += 1
        while self.kinds[self.i] not in OUTER and not self._is_step():
            self.i += 1
        if self.kinds[self.i] in ("END_STEP", "END_TRANSITION", "END_ENTRY", "END_ACTIVE", "END_EXIT"):
            self.i += 1
            self.accept(";")
        self.gather_from(start)
        self.height = 0

    def action(self) -> tree.Action:
        """Read ACTION name: ... END_ACTION."""
        opening = self.i
        self.gather()
        front = self.taken()
        self.enter()
        self.i += 1
        name = self.name("the name of the action")
        if not self.accept(":"):
            self.missing(":", "An action begins with ACTION name:")
        body = self.body()
        self._end("END_ACTION", opening, "ACTION")
        self.depth -= 1
        self.gather_from(opening)
        return tree.Action(
            name, body, position=self.positions[opening], comments=front + self.taken(), remark=self.remark()
        )

    # ---- steps

    def _step_of_chart(self) -> tree.Step:
        opening = self.i
        step = tree.Step("", self.kinds[opening] == "INITIAL_STEP", position=self.positions[opening])
        self.i += 1
        step.name = self.name("the name of the step")
        self.expect(":")
        while self.kinds[self.i] not in OUTER:
            if not self._section(step):
                step.uses += (self._use(),)
        self._end("END_STEP", opening, "STEP")
        return step

    def _section(self, step: tree.Step) -> bool:
        """Read ENTRY ... END_ENTRY and the like.  False if something else follows."""
        at = self.i
        word = self.texts[at].upper()
        is_use = self.kinds[at + 1] in ("(", ";") and self.positions[at + 1].line == self.positions[at].line
        if word not in ("ENTRY", "ACTIVE", "EXIT") or (is_use and word != "EXIT"):
            return False
        field = word.lower()
        if getattr(step, field) is not None:
            self.say(at, f"step {step.name} has a second {word}", "one")
        self.i += 1
        setattr(step, field, self.body())
        self._end(f"END_{word}", at, word)
        return True

    def _use(self) -> tree.ActionUse:
        at = self.i
        use = tree.ActionUse(self.name("the name of an action, or END_STEP"), position=self.positions[at])
        opening = self.i
        if self.accept("("):
            if self.kinds[self.i] != ")":
                self._qualifier(use)
            self.close(")", opening)
        if not self.accept(";"):
            self.missing(";")
        return use

    def _qualifier(self, use: tree.ActionUse) -> None:
        at = self.i
        use.qualifier = self.texts[at].upper()
        if use.qualifier not in QUALIFIERS:
            raise self.unexpected("a qualifier: N, R, S, L, D, P, SD, DS, SL, P0 or P1")
        self.i += 1
        if use.qualifier not in TIMED and self._indicators(use):
            return
        if self.accept(","):
            use.time = self.expression()
            self._indicators(use)
            if use.qualifier not in TIMED:
                self.say(at, f"the qualifier {use.qualifier} has a time", "a time with L, D, SD, DS and SL only")
        elif use.qualifier in TIMED:
            self.missing(", and a time", f"The qualifier {use.qualifier} has a time: ({use.qualifier}, T#5s).")

    def _indicators(self, use: tree.ActionUse) -> bool:
        """Read the indicator variables of an action.  False if there is none."""
        while self.kinds[self.i] == "," and self.kinds[self.i + 1] == token.NAME:
            self.i += 1
            use.indicators += (self.name("the name of a variable"),)
        return bool(use.indicators)

    # ---- transitions

    def _transition(self) -> tree.Transition:
        opening = self.i
        self.i += 1
        name = ""
        if not self.is_word("FROM") and self.kinds[self.i] == token.NAME:
            name = self.name("the name of the transition")
        priority = self._priority()
        self.expect_word("FROM")
        sources = self._steps()
        self.expect("TO")
        targets = self._steps()
        condition: tree.Expression
        if self.accept(":="):
            condition = self._no_assignment(self.expression())
            if not self.accept(";") and self.kinds[self.i] != "END_TRANSITION":
                raise self.unexpected(";")
        elif self.accept(":"):
            condition = self.condition_in_il()
        else:
            raise self.unexpected(":= and the condition")
        self._end("END_TRANSITION", opening, "TRANSITION")
        return tree.Transition(sources, targets, condition, name, priority, position=self.positions[opening])

    def _priority(self) -> int:
        opening = self.i
        if not self.accept("("):
            return 0
        self.expect_word("PRIORITY")
        self.expect(":=")
        text = self.texts[self.i]
        if self.kinds[self.i] != token.INTEGER or not text.isdecimal() or len(text) > 9:
            raise self.unexpected("a number")
        self.i += 1
        self.close(")", opening)
        return int(text)

    def _steps(self) -> tuple[str, ...]:
        opening = self.i
        if not self.accept("("):
            return (self.name("the name of a step"),)
        names = [self.name("the name of a step")]
        while self.accept(","):
            names.append(self.name("the name of a step"))
        self.close(")", opening)
        return tuple(names)
