"""A sequential function chart of an exchange format becomes steps and transitions.

Source: PacDrive manual 1741 to 1842; IEC 61131-3 for divergences.  The chart's lines are followed upwards from each
transition to the steps in front of it, and from each step to the transitions in front of it.  Transitions of one step
are tested by their priority, then from left to right, then in the order of the document.

Blocks and edges in front of a transition are executed while the steps in front of it are active, in an action of the
first of them: the actions of a step run before its transitions are tested, so that nothing comes a cycle late.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.networks import functions
from fieldrig_devices.iec.imports.networks.declarations import BOOL
from fieldrig_devices.iec.imports.networks.graph import Condition, Drawn, Edge, Item, Kind, Network, Pin, Use
from fieldrig_devices.iec.imports.networks.hidden import Hidden
from fieldrig_devices.iec.imports.networks.kinds import Kinds
from fieldrig_devices.iec.imports.networks.terms import conditional
from fieldrig_devices.iec.imports.networks.translate import Translation

QUALIFIERS: Final = frozenset(("N", "R", "S", "L", "D", "P", "SD", "DS", "SL", "P0", "P1"))
"""The qualifiers of the manual (PD-372 to 374) and of edition 3; neither defines the DL of the exchange format."""
TIMED: Final = frozenset(("L", "D", "SD", "DS", "SL"))
BRANCHES: Final = 1_000
"""Steps or transitions that one divergence may lead to."""

_DOWN: Final = (Kind.SELECTION_CONVERGENCE, Kind.SELECTION_DIVERGENCE, Kind.SIMULTANEOUS_DIVERGENCE)
_UP: Final = (Kind.SELECTION_DIVERGENCE, Kind.SELECTION_CONVERGENCE, Kind.SIMULTANEOUS_CONVERGENCE)


@dataclass(slots=True)
class Chart:
    """One chart.  `conditions` are the transitions of the POU that have a name and a body of their own."""

    network: Network
    fragments: Fragments
    hidden: Hidden
    kinds: Kinds
    conditions: dict[str, Condition]
    actions: list[tree.Action]
    """Actions that are written in the chart itself are added here."""
    read: Callable[[Drawn], tree.Body]
    """Reads the body of such an action."""
    items: dict[str, Item] = field(default_factory=dict)
    values: Translation | None = None
    translations: dict[tuple[str, ...], Translation] = field(default_factory=dict)
    """The blocks in front of the transitions that follow the same steps, so that each block is executed once."""
    followers: dict[tuple[str, ...], list[Item]] = field(default_factory=dict)
    """The transitions by the steps in front of them."""
    order: dict[str, int] = field(default_factory=dict)
    """The numbers of the elements in the document."""
    tests: dict[str, list[tree.ActionUse]] = field(default_factory=dict)
    """The actions that compute conditions, by the names of their steps in small letters."""

    def body(self) -> tree.SfcBody:
        self.items = self.network.by_id()
        self.order = {item.id: number for number, item in enumerate(self.network.items)}
        self.values = Translation(self.network, self.fragments, self.hidden, self.kinds)
        steps = [item for item in self.network.items if item.kind is Kind.STEP]
        if not steps:
            self._mistake(self.network.line, "The chart has no step", "at least an initial step")
        elif not any(step.is_initial for step in steps):
            self._mistake(steps[0].line, "The chart has no initial step", 'a step with initialStep="true"')
        transitions = tuple(self._transitions())
        return tree.SfcBody(
            tuple(self._step(step) for step in steps),
            transitions,
            position=tree.Position(self.network.line, 1),
        )

    # ---- transitions

    def _transitions(self) -> list[tree.Transition]:
        targets = self._targets()
        transitions: list[tree.Transition] = []
        tested = self._tested()
        before: list[tuple[str, ...]] = []
        for item in tested:
            with self.fragments.report.inside(f"transition {item.id or item.text}"):
                before.append(self._steps_before(item))
            self.followers.setdefault(before[-1], []).append(item)
        for item, sources in zip(tested, before, strict=True):
            with self.fragments.report.inside(f"transition {item.id or item.text}"):
                condition = self._condition(item, item.condition, sources)
                names = tuple(dict.fromkeys(targets.get(item.id, ())))
                if not sources:
                    self._mistake(item.line, "The transition follows no step", "a line from a step")
                if not names:
                    self._mistake(item.line, "The transition leads to no step", "a line to a step or a jump")
                if sources and names and condition is not None:
                    position = tree.Position(item.line, 1)
                    transitions.append(tree.Transition(sources, names, condition, position=position))
        return transitions

    def _tested(self) -> list[Item]:
        """Transitions in the order in which those of one step are tested."""
        transitions = [item for item in self.network.items if item.kind is Kind.TRANSITION]
        return sorted(transitions, key=lambda item: (item.priority is None, item.priority or 0, item.x))

    def _targets(self) -> dict[str, list[str]]:
        """Names of the steps behind each transition, by its identifier."""
        targets: dict[str, list[str]] = {}
        steps = {item.text.casefold(): item for item in self.network.items if item.kind is Kind.STEP}
        forks = self._forks()
        for item in self.network.items:
            if item.kind is Kind.STEP:
                names = [item.text]
            elif item.kind is Kind.JUMP_STEP:
                names = self._jump(item, steps, forks)
            else:
                continue
            for transition in self._before(item, Kind.TRANSITION, _DOWN):
                targets.setdefault(transition.id, []).extend(names)
        return targets

    def _forks(self) -> dict[str, list[str]]:
        """The steps behind each simultaneous divergence that has a name."""
        forks: dict[str, list[str]] = {}
        for item in self.network.items:
            sources = (self.items.get(wire.source) for pin in item.inputs for wire in pin.wires)
            for fork in sources if item.kind is Kind.STEP else ():
                if fork is not None and fork.kind is Kind.SIMULTANEOUS_DIVERGENCE and fork.text:
                    forks.setdefault(fork.text.casefold(), []).append(item.text)
        return forks

    def _jump(self, item: Item, steps: dict[str, Item], forks: dict[str, list[str]]) -> list[str]:
        """The steps that a jump leads to: the named one, or those behind the named divergence."""
        if item.text.casefold() in steps:
            return [steps[item.text.casefold()].text]
        names = forks.get(item.text.casefold(), [])
        if not names:
            self._mistake(item.line, f"The jump leads to {item.text[:60]}, which is not there", "the name of a step")
        return names

    def _steps_before(self, item: Item) -> tuple[str, ...]:
        return tuple(dict.fromkeys(step.text for step in self._before(item, Kind.STEP, _UP)))

    def _before(self, item: Item, wanted: Kind, passed: tuple[Kind, ...]) -> list[Item]:
        """The elements of a kind in front of an element, through divergences and convergences."""
        items: list[Item] = []
        seen: set[str] = set()
        waiting = [wire.source for pin in reversed(item.inputs) for wire in reversed(pin.wires)]
        while waiting and len(items) < BRANCHES:
            name = waiting.pop()
            other = self.items.get(name)
            if other is None:
                self._mistake(item.line, f"The {item} is connected to element {name[:30]}, which is not there")
            elif name not in seen:
                seen.add(name)
                if other.kind is wanted:
                    items.append(other)
                elif other.kind in passed:
                    waiting.extend(wire.source for pin in reversed(other.inputs) for wire in reversed(pin.wires))
                else:
                    self._mistake(item.line, f"The {item} follows the {other}", f"a {wanted.value} in front of it")
        return items

    # ---- conditions

    def _condition(self, item: Item, condition: Condition | None, sources: tuple[str, ...]) -> tree.Expression | None:
        if condition is None:
            self._mistake(item.line, "The transition has no condition")
            return None
        value = self._plain(item, condition, sources)
        if value is None or not condition.is_negated:
            return value
        return tree.Unary("NOT", value, position=tree.Position(condition.line, 1))

    def _plain(self, item: Item, condition: Condition, sources: tuple[str, ...]) -> tree.Expression | None:
        if condition.name:
            named = self.conditions.get(condition.name.casefold())
            if named is not None and not named.name:
                return self._condition(item, named, sources)
            return self.fragments.expression(condition.name, condition.line)
        if condition.pin is not None:
            return self._computed(item, condition.pin, self._network_of(condition.pin, sources), sources)
        drawn = condition.body
        if drawn is None:
            self._mistake(condition.line, "The transition has no condition")
            return None
        if drawn.language == "ST":
            return self.fragments.expression(_expression_of(drawn.text), drawn.line)
        if drawn.language == "IL":
            return self._by_list(drawn)
        return self._by_network(drawn, sources)

    def _network_of(self, pin: Pin, sources: tuple[str, ...]) -> Translation:
        """Return the network in front of a transition: that of the chart, unless blocks and edges are executed."""
        assert self.values is not None
        before = self._in_front_of([pin])
        if pin.edge is Edge.NONE and not any(item.kind is Kind.BLOCK or item.edge is not Edge.NONE for item in before):
            return self.values
        if sources not in self.translations:
            behind = self.followers[sources]  # their conditions may consume the same values
            pins = [item.condition.pin for item in behind if item.condition is not None]
            items = [*self._in_front_of([one for one in pins if one is not None]), *behind]
            network = replace(self.network, items=items)
            self.translations[sources] = Translation(network, self.fragments, self.hidden, self.kinds)
        return self.translations[sources]

    def _in_front_of(self, pins: list[Pin]) -> list[Item]:
        """The elements whose values flow into these pins, in the order of the document."""
        waiting, seen = [wire for pin in pins for wire in pin.wires], dict[str, Item]()
        while waiting:
            other = self.items.get(waiting.pop().source)
            if other is not None and other.id not in seen:
                seen[other.id] = other
                waiting += [wire for inner in other.pins() for wire in inner.wires]
        return sorted(seen.values(), key=lambda item: self.order[item.id])

    def _computed(self, item: Item, pin: Pin, network: Translation, sources: tuple[str, ...]) -> tree.Expression | None:
        """Return the value at a pin; what has to be executed for it becomes an action of the step."""
        statements, value = network.condition(pin, item)
        if value is None or not statements or not sources:
            return value
        position = tree.Position(item.line, 1)
        result = self.hidden.add("Condition", BOOL, item.line, f"condition of the {item}")
        statements.append(tree.Assign(result, value, position=position))
        others = [tree.Member(tree.Name(name, position=position), "x", position=position) for name in sources[1:]]
        body = statements if not others else [conditional(_all(others, position), statements, item.line)]
        name = self.hidden.free(f"{sources[0][:20]}_condition{len(self.actions) + 1}")
        self.actions.append(tree.Action(name, tree.StBody(tuple(body), position=position), position=position))
        self.tests.setdefault(sources[0].casefold(), []).append(tree.ActionUse(name, "N", position=position))
        return result

    def _by_network(self, drawn: Drawn, sources: tuple[str, ...]) -> tree.Expression | None:
        """A network whose one coil, variable or connector is the transition itself."""
        ends = [
            (network, end)
            for network in drawn.networks
            for end in network.items
            if end.kind in (Kind.COIL, Kind.SINK, Kind.CONNECTOR)
        ]
        if len(ends) != 1:
            self._mistake(drawn.line, f"The condition has {len(ends)} results", "one coil or variable")
            return None
        network, end = ends[0]
        translation = Translation(network, self.fragments, self.hidden, self.kinds)
        value = self._computed(end, end.inputs[0] if end.inputs else Pin(), translation, sources)
        if value is None:
            return None
        return tree.Unary("NOT", value, position=value.position) if end.is_negated else value

    def _by_list(self, drawn: Drawn) -> tree.Expression | None:
        body = self.fragments.body(drawn.text, drawn.line, "IL")
        value = _accumulator(body.instructions) if isinstance(body, tree.IlBody) else None
        if value is None:
            self._mistake(
                drawn.line,
                "The condition does more than calculate",
                "a list of LD, AND, OR, XOR, NOT and comparisons",
                "Put the list into an action of the step, and test a variable that it sets.",
            )
        return value

    # ---- steps

    def _step(self, item: Item) -> tree.Step:
        with self.fragments.report.inside(f"step {item.text[:60]}"):
            self.fragments.is_name(item.text, item.line, "a step")
            uses = [use for block in self._blocks(item) for use in self._uses(item, block)]
            uses += self.tests.get(item.text.casefold(), [])
            phases = {phase: _calling(name, item.line) for phase, name in item.phases.items() if name}
            return tree.Step(
                item.text,
                item.is_initial,
                tuple(uses),
                phases.get("entry"),
                phases.get("active"),
                phases.get("exit"),
                position=tree.Position(item.line, 1),
            )

    def _blocks(self, step: Item) -> list[Item]:
        """Action blocks and variables that are connected to the step."""
        assert self.values is not None
        items = (item for item, _, _ in self.values.consumers.get(step.id, ()))
        return list({item.id: item for item in items if item.kind in (Kind.ACTIONS, Kind.SINK)}.values())

    def _uses(self, step: Item, block: Item) -> list[tree.ActionUse]:
        if block.kind is Kind.SINK:
            if not block.is_negated:
                return [tree.ActionUse(block.text, "N", position=tree.Position(block.line, 1))]
            self._mistake(block.line, f"The {block} takes the negated step", "the step itself, or an action")
            return []
        if block.is_negated:
            self._mistake(block.line, "The action block is negated", "an action block that follows its step")
        return [read for use in block.uses if (read := self._use(step, use)) is not None]

    def _use(self, step: Item, use: Use) -> tree.ActionUse | None:
        qualifier = use.qualifier.strip().upper() or "N"
        if qualifier not in QUALIFIERS:
            self._mistake(use.line, f"The qualifier {qualifier[:10]} is not known", ", ".join(sorted(QUALIFIERS)))
            return None
        time = self.fragments.expression(use.duration, use.line) if use.duration.strip() else None
        if qualifier in TIMED and time is None:
            self._mistake(use.line, f"The qualifier {qualifier} needs a time", "a duration such as T#3s")
            return None
        name = use.name or self._own_action(step, use)
        if not name:
            self._mistake(use.line, "The action has neither a name nor a body")
            return None
        return tree.ActionUse(
            name, qualifier, time if qualifier in TIMED else None, position=tree.Position(use.line, 1)
        )

    def _own_action(self, step: Item, use: Use) -> str:
        if use.body is None:
            return ""
        name = self.hidden.free(f"{step.text[:20]}_action{len(self.actions) + 1}")
        self.actions.append(tree.Action(name, self.read(use.body), position=tree.Position(use.line, 1)))
        return name

    def _mistake(self, line: int, what: str, expected: str = "", hint: str = "") -> None:
        self.fragments.report.mistake(line, what, expected, hint)


def _all(values: list[tree.Member], position: tree.Position) -> tree.Expression:
    return functions.balanced("AND", list[tree.Expression](values), position)


def _calling(action: str, line: int) -> tree.Body:
    position = tree.Position(line, 1)
    call = tree.Call(tree.Name(action, position=position), (), position=position)
    return tree.StBody((tree.CallStatement(call, position=position),), position=position)


def _expression_of(text: str) -> str:
    """The expression in a condition: tools write `expression`, `:= expression;` or `name := expression;`."""
    stripped = text.rstrip().rstrip(";")
    before, mark, behind = stripped.partition(":=")
    if mark and not before.strip().strip("_").replace("_", "").isalnum() and before.strip():
        return stripped
    return "\n" * before.count("\n") + behind if mark else stripped


_OPERATORS: Final[dict[str, str]] = {
    "AND": "AND", "OR": "OR", "XOR": "XOR", "GT": ">", "GE": ">=", "EQ": "=", "LE": "<=", "LT": "<", "NE": "<>",
    "ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/",
}  # fmt: skip


def _accumulator(instructions: tuple[tree.IlInstruction, ...]) -> tree.Expression | None:
    """The accumulator behind a list that only calculates; None for any other list."""
    result: tree.Expression | None = None
    for line in instructions:
        if line.label or line.is_conditional or len(line.operands) > 1:
            return None
        operand = line.operands[0] if line.operands else _accumulator(line.deferred) if line.deferred else None
        if line.operator == "NOT" and operand is None and result is not None:
            result = _not(result)
            continue
        if operand is None:
            return None
        operand = _not(operand) if line.is_negated else operand
        if line.operator == "LD":
            result = operand
        elif line.operator in _OPERATORS and result is not None:
            result = tree.Binary(_OPERATORS[line.operator], result, operand, position=line.position)
        elif line.operator != "ST":
            return None
    return result


def _not(value: tree.Expression) -> tree.Expression:
    return tree.Unary("NOT", value, position=value.position)
