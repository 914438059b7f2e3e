"""Sequential Function Charts: steps, transitions and actions become statements over hidden variables.

Source: PacDrive manual 1709 to 1842 (digest 2.3), IEC 61131-3 for the control of actions.  In each cycle

1. the actions run: of each active simple step, in the order of the text, its entry action if this is its first cycle,
   and then its active action; after that the named actions of the IEC steps, in the order of their first use;
2. the transitions behind active steps are tested, those of the same step by priority and then by the text, so that one
   step starts one of its alternative branches;
3. the steps in front of the transitions that hold become inactive, after their exit actions, and those behind become
   active.  Their actions run in the next cycle.  A step that is in front and behind ends and begins again
   (IEC 61131-3, 6.7.5: the deactivation is followed by the activation), with P0 and P1 in the same cycle.

A step is a variable of its chart with the components x (active) and t (time since its actions began), as in CoDeSys.
The qualifiers of a named action are combined as in the ACTION_CONTROL block of the standard, where R is stronger than
all others.  There is no final scan, so that P is executed exactly once (manual 1815).  A BOOL variable may be named
instead of an action; it is TRUE while the action would run.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import sfc_flags
from fieldrig_devices.iec.check.charts import check_chart
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.statements import Statements
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import AnyStatement, If, Pou, Space, Variable
from fieldrig_devices.iec.tree import Member, Name, PouKind, Section
from fieldrig_devices.iec.types import Field, InitialValue, StructType, Type

STEP: Final = StructType(
    "SFCStepType",
    {
        "x": Field("x", Elementary.BOOL, 0, comment="The step is active."),
        "t": Field("t", Elementary.TIME, 1, comment="Time since the actions of the step began."),
        "_x": Field("_x", Elementary.BOOL, 5, comment="The step was active in the last cycle."),
        "_t": Field("_t", Elementary.TIME, 6, comment="When its actions began."),
    },
    10,
)
"""The type of steps, with the names that CoDeSys V2.3 gives to the components."""

_TRUE: Final = tree.Literal(tree.LiteralKind.BOOL, True)
_FALSE: Final = tree.Literal(tree.LiteralKind.BOOL, False)


BodyOf = Callable[[Pou, tree.Body], list[AnyStatement]]
"""Checks the body of an action."""


def lower_sfc(body: tree.SfcBody, context: Context, body_of: BodyOf) -> list[AnyStatement]:
    """Return the statements of one cycle of a chart.  The actions of simple steps become actions of the POU."""
    if context.owner is not None and context.owner.kind is PouKind.FUNCTION:
        context.say(body, "a FUNCTION cannot be written in SFC", "ST or IL", "A function has no memory for its steps.")
        return []
    if not check_chart(body, context):
        return []
    return _Chart(body, context, body_of).cycle()


@dataclass(slots=True)
class _Control:
    """A named action of IEC steps, with all steps that use it."""

    name: str
    uses: list[tuple[str, tree.ActionUse]] = field(default_factory=list)


class _Chart:
    def __init__(self, body: tree.SfcBody, context: Context, body_of: BodyOf) -> None:
        self._steps, self._body_of = body.steps, body_of
        self._transitions = sorted(body.transitions, key=lambda transition: transition.priority)
        self._context = context
        self._made: list[tree.AnyStatement] = []
        self._position = body.position
        self._origins: dict[int, tree.Node] = {}
        """The steps and transitions, by the statements that run while they are active, or when they fire."""
        self._stores: list[tree.Expression] = []
        """The variables that keep named actions on: stored ones, and BOOL variables."""
        self._flags = sfc_flags.declared_flags(context)
        self._ends: dict[str, Name] = {}
        """Variables by the keys of steps with an action of P0: the step has just been left."""

    def cycle(self) -> list[AnyStatement]:
        for step in self._steps:
            self._declare_step(step)
        self._sections = {self._context.key(step.name): self._routines(step) for step in self._steps}
        self._now = self._hidden("now", Elementary.TIME)
        self._run()
        self._steer()
        made = Statements(self._context).body(self._made)
        come_from(made, self._origins)
        return made

    def _run(self) -> None:
        """Add the statements of a cycle that is not held up."""
        self._add(_assign(self._now, tree.Call(Name("TIME"), ())))
        for step in self._steps:
            self._time(step)
        for step in self._steps:
            self._simple_step(step)
        for control in self._controls():
            self._action(control)
        for step in self._steps:
            self._position = step.position
            self._add(_assign(_flag(step.name, "_x"), _flag(step.name, "x")))
        for ended in self._ends.values():
            self._add(_assign(ended, _FALSE))
        self._test_and_switch()

    # ---- 0: what the program wants of the chart (`sfc_flags`)

    def _steer(self) -> None:
        """Begin with what the flags of the program want, and let the cycle run only if they do not hold it up."""
        run, self._made, self._position = tuple(self._made), [], tree.NOWHERE
        init, again = self._flags.get(sfc_flags.INIT), sfc_flags.any_of(self._flags, sfc_flags.INIT, sfc_flags.RESET)
        if again is not None:
            self._if(again, *self._beginning())
        if init is not None:
            first = next(step for step in self._steps if step.is_initial)
            self._if(init, _assign(_flag(first.name, "_x"), _FALSE))
        self._name_step()
        held = sfc_flags.any_of(self._flags, sfc_flags.INIT, sfc_flags.PAUSE)
        if held is None:
            self._made += run
        else:
            branch = tree.Branch(_not(held), run, position=tree.NOWHERE)
            self._add(tree.If((branch,), position=tree.NOWHERE))
        self._name_step()

    def _beginning(self) -> list[tree.AnyStatement]:
        """Return what leaves all steps and actions but the initial step, which goes on if it is active."""
        made: list[tree.AnyStatement] = []
        for step in self._steps:
            made.append(_assign(_flag(step.name, "x"), _TRUE if step.is_initial else _FALSE))
            if not step.is_initial:
                made.append(_assign(_flag(step.name, "_x"), _FALSE))
        made += [_assign(store, _FALSE) for store in self._stores]
        fired = self._flags.get(sfc_flags.FIRED)
        return [*made, _assign(fired, _FALSE)] if fired is not None else made

    def _name_step(self) -> None:
        name = self._flags.get(sfc_flags.STEP)
        if name is not None:
            for step in self._steps:
                self._if(_flag(step.name, "x"), _assign(name, tree.Literal(tree.LiteralKind.STRING, step.name)))

    # ---- variables

    def _declare_step(self, step: tree.Step) -> None:
        context, owner = self._context, self._context.owner
        assert owner is not None
        initial: dict[str, InitialValue] | None = {"x": True} if step.is_initial else None
        made = Variable(
            step.name, STEP, Space.INSTANCE, Section.LOCAL, initial, position=step.position, file=context.file
        )
        made.comment = f"Step {step.name}"
        owner.variables[context.key(step.name)] = made
        context.names[context.key(step.name)] = made

    def _hidden(self, name: str, kind: Type) -> Name:
        made = self._context.hidden(name, kind)
        self._context.names[self._context.key(made.name)] = made
        return Name(made.name)

    def _routines(self, step: tree.Step) -> dict[str, str]:
        """Make an action of each action that a simple step has; return their names."""
        made = {}
        owner = self._context.owner
        assert owner is not None
        for word in ("entry", "active", "exit"):
            body: tree.Body | None = getattr(step, word)
            if body is None:
                continue
            key = f"{word}.{len(owner.actions)}"
            name = f"{owner.name}.{step.name}.{word}"
            action = Pou(owner.kind, name, owner.file, owner.variables, type=owner.type, owner=owner)
            owner.actions[key] = action
            action.body = self._body_of(action, body)
            made[word] = key
        return made

    # ---- statements

    def _add(self, statement: tree.AnyStatement) -> None:
        statement.position = self._position
        self._made.append(statement)

    def _if(self, condition: tree.Expression, *then: tree.AnyStatement) -> None:
        self._add(_conditional(condition, then, self._position))

    # ---- 1: actions

    def _time(self, step: tree.Step) -> None:
        """The time of a step counts from the first cycle of its actions."""
        self._position = step.position
        begin = _conditional(
            _not(_flag(step.name, "_x")), (_assign(_flag(step.name, "_t"), self._now),), self._position
        )
        elapsed = tree.Binary("-", self._now, _flag(step.name, "_t"))
        self._if(_flag(step.name, "x"), begin, _assign(_flag(step.name, "t"), elapsed))
        self._origins[id(self._made[-1])] = step

    def _simple_step(self, step: tree.Step) -> None:
        self._position = step.position
        sections = self._sections[self._context.key(step.name)]
        if "entry" in sections:
            self._if(self._begins(step.name), _call(sections["entry"]))
        if "active" in sections:
            self._if(_flag(step.name, "x"), _call(sections["active"]))

    def _begins(self, step: str) -> tree.Expression:
        return _and(_flag(step, "x"), _not(_flag(step, "_x")))

    def _ended(self, step: str) -> Name:
        """Return whether the last transitions left a step, which is active again if they entered it as well."""
        key = self._context.key(step)
        if key not in self._ends:
            self._ends[key] = self._hidden("ended", Elementary.BOOL)
            self._stores.append(self._ends[key])
        return self._ends[key]

    def _controls(self) -> list[_Control]:
        controls: dict[str, _Control] = {}
        for step in self._steps:
            for use in step.uses:
                control = controls.setdefault(self._context.key(use.name), _Control(use.name))
                control.uses.append((step.name, use))
        return list(controls.values())

    def _action(self, control: _Control) -> None:
        """Compute whether an action runs, and run it (ACTION_CONTROL of the standard)."""
        self._position = control.uses[0][1].position
        resets = [_flag(step, "x") for step, use in control.uses if use.qualifier == "R"]
        is_reset = self._kept("reset", resets) if resets else None
        reasons = [self._reason(step, use, is_reset) for step, use in control.uses if use.qualifier != "R"]
        stored = self._stored(control, is_reset)
        runs = _any([*reasons, *stored]) if reasons or stored else _FALSE
        if is_reset is not None:
            runs = _and(_not(is_reset), runs)
        action = Name(control.name, position=self._position)
        owner = self._context.owner
        if owner is not None and self._context.key(control.name) in owner.actions:
            self._if(runs, tree.CallStatement(tree.Call(action, (), position=self._position)))
        else:
            self._stores.append(action)
            self._add(_assign(action, runs))

    def _kept(self, name: str, reasons: Sequence[tree.Expression]) -> tree.Expression:
        """Return whether one of these holds; several of them are looked at once, for all who need to know."""
        if len(reasons) == 1:
            return reasons[0]
        kept = self._hidden(name, Elementary.BOOL)
        self._add(_assign(kept, _any(reasons)))
        return kept

    def _reason(self, step: str, use: tree.ActionUse, is_reset: tree.Expression | None) -> tree.Expression:
        """Return why an action runs in this cycle, apart from what is stored."""
        active = _flag(step, "x")
        time = use.time or _FALSE
        match use.qualifier:
            case "L":
                return _and(active, tree.Binary("<", _flag(step, "t"), time, position=use.position))
            case "D":
                return _and(active, tree.Binary(">=", _flag(step, "t"), time, position=use.position))
            case "P" | "P1":
                return self._begins(step)
            case "P0":
                return self._ended(step)
            case "SD":
                return self._delayed(step, use, ">=", is_reset)
            case "SL":
                return self._delayed(step, use, "<", is_reset)
            case "S" | "DS":
                return _FALSE
        return active

    def _delayed(
        self, step: str, use: tree.ActionUse, operator: str, is_reset: tree.Expression | None
    ) -> tree.Expression:
        """Store that the step was active, and since when; R clears it."""
        is_on, begin = self._hidden("on", Elementary.BOOL), self._hidden("begin", Elementary.TIME)
        self._stores.append(is_on)
        self._if(_and(_flag(step, "x"), _not(is_on)), _assign(is_on, _TRUE), _assign(begin, self._now))
        if is_reset is not None:
            self._if(is_reset, _assign(is_on, _FALSE))
        elapsed = tree.Binary("-", self._now, begin)
        return _and(is_on, tree.Binary(operator, elapsed, use.time or _FALSE, position=use.position))

    def _stored(self, control: _Control, is_reset: tree.Expression | None) -> list[tree.Expression]:
        """Store an action with S or DS, and clear it with R."""
        sets: list[tree.Expression] = []
        for step, use in control.uses:
            if use.qualifier == "S":
                sets.append(_flag(step, "x"))
            elif use.qualifier == "DS":
                late = tree.Binary(">=", _flag(step, "t"), use.time or _FALSE, position=use.position)
                sets.append(_and(_flag(step, "x"), late))
        if not sets:
            return []
        stored = self._hidden("stored", Elementary.BOOL)
        self._stores.append(stored)
        self._if(_any(sets), _assign(stored, _TRUE))
        if is_reset is not None:
            self._if(is_reset, _assign(stored, _FALSE))
        return [stored]

    # ---- 2 and 3: transitions

    def _test_and_switch(self) -> None:
        fired: list[tuple[tree.Transition, Name]] = []
        held, tipped = self._flags.get(sfc_flags.RESET), self._tipped()
        left = self._with_alternatives()
        for transition in self._transitions:
            self._position = transition.position
            name = self._hidden("fires", Elementary.BOOL)
            taken = [left[key] for key in self._keys(transition) if key in left]
            enabled = _all([*(_flag(step, "x") for step in transition.sources), *(_not(other) for other in taken)])
            self._add(_assign(name, _FALSE))
            if held is not None:
                enabled = _and(enabled, _not(held))
            self._if(enabled, *self._tested(name, transition, tipped))
            if taken:
                self._if(name, *(_assign(other, _TRUE) for other in taken))
            fired.append((transition, name))
        self._note_fired([name for _, name in fired])
        for transition, name in fired:
            self._position = transition.position
            self._if(name, *(statement for step in transition.sources for statement in self._leave(step)))
            self._origins[id(self._made[-1])] = transition
        for transition, name in fired:
            self._position = transition.position
            self._if(name, *(self._enter(step) for step in transition.targets))

    def _note_fired(self, fired: Sequence[Name]) -> None:
        flag = self._flags.get(sfc_flags.FIRED)
        if flag is not None and fired:
            self._add(_assign(flag, _FALSE))
            for name in fired:
                self._if(name, _assign(flag, _TRUE))

    def _tipped(self) -> Name | None:
        """Return whether the program moves the chart on by hand in this cycle; None if it has no such flags."""
        mode = self._flags.get(sfc_flags.TIP_MODE)
        if mode is None:
            return None
        tip, tipped, before = self._flags[sfc_flags.TIP], self._hidden("tipped", Elementary.BOOL), "tip before"
        last = self._hidden(before, Elementary.BOOL)
        self._position = tree.NOWHERE
        self._add(_assign(tipped, _and(_and(mode, tip), _not(last))))
        self._add(_assign(last, tip))
        return tipped

    def _tested(self, name: Name, transition: tree.Transition, tipped: Name | None) -> list[tree.AnyStatement]:
        """Return the test of a transition whose steps are active."""
        test = _assign(name, transition.condition, transition.condition.position)
        if tipped is None:
            return [test]
        mode = self._flags[sfc_flags.TIP_MODE]
        by_hand = tree.Branch(mode, (_assign(name, tipped),), position=transition.position)
        return [tree.If((by_hand,), (test,), position=transition.position)]

    def _with_alternatives(self) -> dict[str, Name]:
        """Return, for each step with several transitions, a variable that is set when one of them fires: the first one
        counts.  To ask each transition for all before it would take the square of their number.
        """
        counts = Counter(key for transition in self._transitions for key in set(self._keys(transition)))
        left = {key: self._hidden("left", Elementary.BOOL) for key, count in counts.items() if count > 1}
        for name in left.values():
            self._add(_assign(name, _FALSE))
        return left

    def _keys(self, transition: tree.Transition) -> list[str]:
        return [self._context.key(step) for step in transition.sources]

    def _leave(self, step: str) -> list[tree.AnyStatement]:
        sections = self._sections[self._context.key(step)]
        exit_call = [_call(sections["exit"])] if "exit" in sections else []
        ended = self._ends.get(self._context.key(step))
        noted = [_assign(ended, _TRUE)] if ended is not None else []
        return [*exit_call, _assign(_flag(step, "x"), _FALSE), *noted]

    def _enter(self, step: str) -> tree.AnyStatement:
        """Make a step active; one that has just been left begins again."""
        activate = (_assign(_flag(step, "x"), _TRUE), _assign(_flag(step, "_x"), _FALSE))
        return _conditional(_not(_flag(step, "x")), activate, self._position)


def come_from(statements: Sequence[AnyStatement], origins: Mapping[int, tree.Node]) -> None:
    """Say what the statements come from that the compiler has written, by the ids of its trees: mostly from nothing."""
    for statement in statements:
        statement.origin = origins.get(id(statement.origin))
        if isinstance(statement, If):
            come_from([*statement.then, *statement.otherwise], origins)


# ---- trees


def _flag(step: str, name: str) -> Member:
    return Member(Name(step), name)


def _assign(target: tree.Expression, value: tree.Expression, position: tree.Position = tree.NOWHERE) -> tree.Assign:
    return tree.Assign(target, value, position=position)


def _call(name: str) -> tree.CallStatement:
    return tree.CallStatement(tree.Call(Name(name), ()))


def _conditional(condition: tree.Expression, then: Sequence[tree.AnyStatement], position: tree.Position) -> tree.If:
    for statement in then:
        statement.position = position
    return tree.If((tree.Branch(condition, tuple(then), position=position),), position=position)


def _not(operand: tree.Expression) -> tree.Expression:
    return tree.Unary("NOT", operand)


def _and(left: tree.Expression, right: tree.Expression) -> tree.Expression:
    return tree.Binary("AND", left, right)


def _all(parts: Sequence[tree.Expression]) -> tree.Expression:
    joined = parts[0]
    for part in parts[1:]:
        joined = _and(joined, part)
    return joined


def _any(parts: Sequence[tree.Expression]) -> tree.Expression:
    joined = parts[0]
    for part in parts[1:]:
        joined = tree.Binary("OR", joined, part)
    return joined
