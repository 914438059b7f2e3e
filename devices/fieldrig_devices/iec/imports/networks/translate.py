"""Networks of ladder diagram and function block diagram become statements.

Source: PacDrive manual 4.4 (lines 1844 to 1913), PD-380; IEC 61131-3 for edges, and for what the manual's figures show.

- An element is executed where its first consumer needs it; the rest follows in the order of `order.in_order`.
- Power that several elements consume is calculated once, in a hidden variable.
- A wire that closes a loop carries the value of the previous cycle.
- A block with EN is executed only while EN is TRUE.  A variable at its output otherwise keeps its value, as in CoDeSys
  V2.3; the result of a comparison is FALSE, because power does not flow through it.
- ENO is EN.  In edition 3 the code of a block may set it, so the call has an argument ENO there (`check/enable.py`).
- A rising edge is TRUE for one execution.  The first execution after the start compares with FALSE.
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.fragments import Fragments
from fieldrig_devices.iec.imports.networks.blocks import Blocks
from fieldrig_devices.iec.imports.networks.graph import Item, Kind, Network, Pin, Storage
from fieldrig_devices.iec.imports.networks.hidden import Hidden
from fieldrig_devices.iec.imports.networks.kinds import Kinds
from fieldrig_devices.iec.imports.networks.order import in_order
from fieldrig_devices.iec.imports.networks.terms import conditional, is_true, negated, position_of

_ACTORS: Final = (Kind.SINK, Kind.THROUGH, Kind.COIL, Kind.BLOCK, Kind.LABEL, Kind.JUMP, Kind.RETURN)


def translate(
    networks: list[Network], fragments: Fragments, hidden: Hidden, kinds: Kinds
) -> tuple[tree.AnyStatement, ...]:
    """The statements of the networks of one body."""
    statements: list[tree.AnyStatement] = []
    comments: tuple[str, ...] = ()
    for network in networks:
        hidden.network += 1
        with fragments.report.inside(f"network {hidden.network}"):
            translated = Translation(network, fragments, hidden, kinds).statements()
        comments += network.comments + _comments(network)
        if translated:
            translated[0].comments = (*comments, *translated[0].comments)
            comments = ()
        statements += translated
    return tuple(statements)


def _comments(network: Network) -> tuple[str, ...]:
    texts = (item.text.strip() for item in network.items if item.kind in (Kind.COMMENT, Kind.TITLE))
    return tuple(f"(* {text.replace('(*', '( *').replace('*)', '* )')} *)" for text in texts if text)


@dataclass(slots=True)
class Translation(Blocks):
    """One network."""

    def statements(self) -> list[tree.AnyStatement]:
        if self.network.label and self.fragments.is_name(self.network.label, self.network.line, "a label"):
            self.put(tree.Label(self.network.label, position=tree.Position(self.network.line, 1)))
        ordered = [item for item in in_order(self.network.items) if item.kind in _ACTORS]
        # A function is executed where its result is needed; what is left then has no result that anything needs.
        for item in (*(i for i in ordered if not self._is_demanded(i)), *ordered):
            self.order = item.order
            self.execute(item)
        for item in self.network.items:
            if item.kind is Kind.CONTACT and item.id not in self.consumers:
                self.fragments.report.note(item.line, f"The {item} leads to nothing")
        return self.out

    def _is_demanded(self, item: Item) -> bool:
        return item.kind is Kind.BLOCK and not item.instance and item.id in self.consumers

    def condition(self, pin: Pin, owner: Item) -> tuple[list[tree.AnyStatement], tree.Expression | None]:
        """Return the statements that a condition of a chart needs first, and its value; None with a message."""
        value = self.input(pin, owner)
        before, self.out = self.out, []
        return before, value

    # ---- execution

    def execute(self, item: Item) -> None:
        if item.id in self.started:
            return
        self.started.add(item.id)
        match item.kind:
            case Kind.SINK | Kind.COIL:
                self._assign(item)
            case Kind.THROUGH if any(pin.wires for pin in item.inputs):
                self._assign(item)
            case Kind.BLOCK:
                self.block(item)
            case Kind.LABEL if self.fragments.is_name(item.text, item.line, "a label"):
                self.put(tree.Label(item.text, position=position_of(item)))
            case Kind.JUMP if self.fragments.is_name(item.text, item.line, "a label"):
                self._leave(item, tree.Jump(item.text, position=position_of(item)))
            case Kind.RETURN:
                self._leave(item, tree.Return(position=position_of(item)))
        self.finished.add(item.id)

    def _leave(self, item: Item, statement: tree.AnyStatement) -> None:
        if not any(pin.wires or pin.expression for pin in item.inputs):
            self.put(statement)
            return
        condition = self.power(item)
        if condition is None:
            return
        if item.is_negated:
            condition = negated(condition)
        self.put(statement if is_true(condition) else conditional(condition, [statement], item.line))

    def _assign(self, item: Item) -> None:
        target = self.fragments.place(item.text, item.line)
        value = self.power(item)
        if target is None or value is None or item.id in self.written:
            return
        if item.is_negated:
            value = negated(value)
        value = self.edge(value, item.edge, item)
        if item.storage is Storage.NONE:
            self.put(tree.Assign(target, value, position=position_of(item)))
            return
        constant = tree.Literal(tree.LiteralKind.BOOL, item.storage is Storage.SET, position=position_of(item))
        self.put(conditional(value, [tree.Assign(target, constant, position=position_of(item))], item.line))
