"""Tasks, actions, routines and equations of an application, one after the other."""

import re
from collections.abc import Iterator, Sequence
from typing import Final

from fieldrig_devices.languages.instructions import Call, Instruction, Routine
from fieldrig_devices.pam.language import items, tree
from fieldrig_devices.pam.language.functions import Type
from fieldrig_devices.pam.language.tree import Expression, Number, Reference, RoutineCall
from fieldrig_devices.pam.runtime import sizes
from fieldrig_devices.pam.runtime.layout import Layout, is_per_item, number_of
from fieldrig_devices.pam.runtime.lower import lowered
from fieldrig_devices.pam.runtime.lower.expressions import Expressions, Formal, Surroundings
from fieldrig_devices.pam.runtime.lower.lowered import Lowered, routine_name
from fieldrig_devices.pam.runtime.lower.sequences import SequenceBody
from fieldrig_devices.pam.runtime.lower.statements import Body
from fieldrig_devices.pam.runtime.lower.uses import Verb
from fieldrig_devices.pam.runtime.walk import nodes

_CELL: Final = re.compile(r"M\[[^\]:]*\]")
DEFAULT_WORKSPACE: Final = 4096
"""Bytes (manual line 9268)."""


def lower(program: items.Program, layout: Layout) -> Lowered:
    return _Lowerer(program, layout).code


class _Lowerer:
    def __init__(self, program: items.Program, layout: Layout) -> None:
        self._layout = layout
        self.code = Lowered()
        self._expressions = Expressions(layout, self.code.uses, self.code.formulas)
        self._watched = frozenset(_watched(program))
        self._routines: dict[str, items.Routine] = {}
        self._wanted: list[tuple[str, tuple[Type, ...]]] = []
        self._default_workspace = DEFAULT_WORKSPACE
        self._sequences = 0
        for item in program.items:
            self._item(item)
        while self._wanted:
            self._routine(*self._wanted.pop())
        self.code.stack_size = _deepest(self.code.routines)

    def _item(self, item: items.Item) -> None:
        match item:
            case items.Application():
                given = number_of(item.parameters, "DEFAULT_TASK_WORKSPACE")
                self._default_workspace = DEFAULT_WORKSPACE if given is None else given
            case items.Declaration():
                self._connected(item)
            case items.BooleanEquation():
                self._equation(item)
            case items.Routines():
                self._routines |= {routine.name: routine for routine in item.routines}
                self._power_on(item.name, item.power_on, item.place)
            case items.Actions():
                self._actions(item)
            case items.Task():
                self._task(item)

    def _equation(self, item: items.BooleanEquation) -> None:
        cells = self._layout.cells[item.name]
        formula = self._expressions.formula(item.equation, item.name)
        linked = item.linked_output
        self.code.equations.append(
            lowered.EquationCode(
                item.name,
                cells.first,
                cells.count,
                formula,
                None if linked is None else linked.name,
                item.is_multiple,
            )
        )

    # ---- routines

    def _connected(self, item: items.Declaration) -> None:
        """Make the code for the routines that a declaration connects, whose arguments are constants (PAML-276)."""
        for parameter in (*item.parameters, *(own for part in item.parts for own in part.parameters)):
            for value in parameter.values:
                if isinstance(value, RoutineCall) and value.routine:
                    self._on_call(value.routine, tuple(map(_type_of_constant, value.arguments)))

    def _on_call(self, routine: str, types: tuple[Type, ...]) -> None:
        known = self.code.signatures.setdefault(routine, [])
        if types not in known:
            known.append(types)
            self._wanted.append((routine, types))

    def _routine(self, name: str, types: tuple[Type, ...]) -> None:
        routine = self._routines[name]
        pairs = zip(routine.formals, types, strict=True)
        formals = {formal: Formal(slot, value_type) for slot, (formal, value_type) in enumerate(pairs)}
        self._add(routine_name(name, types), name, routine.body, routine.place, Surroundings(formals))

    def _add(self, key: str, title: str, body: Sequence[tree.Statement], place: tree.Place, at: Surroundings) -> None:
        body_class = SequenceBody if at.asks is Verb.LATER else Body
        lowerer = body_class(self._expressions, self.code, self._watched, at, self._on_call, title)
        instructions = lowerer.lower(body, _end(body, place))
        self.code.marked.places += lowerer.marks.places
        self.code.routines[key] = Routine(instructions, lowerer.frame_size, frozenset(_registers(instructions)))
        self.code.titles[key] = title

    # ---- actions and tasks

    def _power_on(self, owner: str, body: tuple[tree.Statement, ...] | None, place: tree.Place) -> None:
        if body is None:
            return
        key = f"power-on {owner}"
        self._add(key, f"{owner}.POWERON", body, place, Surroundings(items=owner))
        self.code.power_on.append(lowered.PowerOnCode(owner, key, is_per_item(body)))

    def _actions(self, item: items.Actions) -> None:
        reactions = []
        for number, reaction in enumerate(item.reactions):
            key = f"action {item.name} {number}"
            formula = self._expressions.formula(reaction.condition, item.name)
            self._add(key, f"{item.name}.{number + 1}", reaction.body, reaction.place, Surroundings(items=item.name))
            reactions.append(lowered.ReactionCode(reaction.trigger == "ON_EVENT", formula, key))
        count, cycles = self._layout.counts[item.name], max(number_of(item.specs, "CYCLES") or 1, 1)
        self.code.actions.append(lowered.ActionsCode(item.name, count, cycles, tuple(reactions)))
        self.code.order.append(item.name)
        self._power_on(item.name, item.power_on, item.place)

    def _task(self, item: items.Task) -> None:
        given = number_of(item.specs, "DEFAULT_SEQUENCE_WORKSPACE")
        workspace = self._default_workspace if given is None else given
        sequences = {sequence.name: self._sequence(item, sequence, workspace) for sequence in item.sequences}
        power_on = None
        if item.power_on is not None:
            part = items.Sequence(item.place, "", is_per_item(item.power_on), (), item.power_on)
            power_on = self._sequence(item, part, workspace)
        events = tuple(
            lowered.EventCode(
                self._expressions.formula(event.condition, item.name), event.sequence.name, event.sequence.is_indexed
            )
            for event in item.events
        )
        self.code.tasks.append(
            lowered.TaskCode(
                item.name,
                self._layout.counts[item.name],
                max(number_of(item.specs, "CYCLES") or 1, 1),
                number_of(item.specs, "DUPL"),
                events,
                sequences,
                power_on,
            )
        )
        self.code.order.append(item.name)

    def _sequence(self, task: items.Task, sequence: items.Sequence, workspace: int) -> lowered.SequenceCode:
        self._sequences += 1
        key = f"sequence {task.name} {sequence.name}"
        at = Surroundings(asks=Verb.LATER, items=task.name)
        self._add(key, f"{task.name}.{sequence.name or 'POWERON'}", sequence.body, sequence.place, at)
        own = number_of(sequence.specs, "WORKSPACE")
        return lowered.SequenceCode(
            self._sequences,
            task.name,
            sequence.name,
            key,
            sequence.place,
            workspace if own is None else own,
            sizes.workspace(sequence.body, self._routines),
            sequence.is_multiple,
        )


def _type_of_constant(argument: Expression) -> Type:
    return "real" if isinstance(argument, Number) and isinstance(argument.value, float) else "integer"


def _end(body: Sequence[tree.Statement], place: tree.Place) -> tree.Place:
    """Return the place of the last node of a body, for the instruction that ends it."""
    inside = [node.place for node in nodes(*body) if node.place.file == place.file]
    return max([place, *inside], key=lambda each: (each.line, each.column))


def _registers(instructions: Sequence[Instruction]) -> Iterator[str]:
    """Yield the cells of a routine, which a block may keep in local variables (`languages.registers`)."""
    for instruction in instructions:
        texts = (*getattr(instruction, "python", ()), getattr(instruction, "condition", ""))
        yield from (text for part in texts for text in _CELL.findall(part))


def _watched(program: items.Program) -> Iterator[str]:
    """Yield the names that conditions, events, exceptions and equations depend on."""
    conditions: list[Expression] = []
    for node in nodes(*program.items):
        match node:
            case items.BooleanEquation(equation=equation):
                conditions.append(equation)
            case items.Event(condition=condition) | items.Reaction(condition=condition):
                conditions.append(condition)
            case tree.Condition(condition=condition) | tree.Branch(condition=condition):
                conditions.append(condition)
            case tree.ArmException(condition=condition):
                conditions.append(condition)
    yield from (node.name for node in nodes(*conditions) if isinstance(node, Reference))


def _deepest(routines: dict[str, Routine]) -> int:
    """Return the most cells that calls in each other need."""
    known: dict[str, int] = {}

    def needed(name: str) -> int:
        if name not in known:
            called = [one.routine for one in routines[name].instructions if isinstance(one, Call)]
            known[name] = routines[name].frame_size + max(map(needed, called), default=0)
        return known[name]

    return max(map(needed, routines), default=0)
