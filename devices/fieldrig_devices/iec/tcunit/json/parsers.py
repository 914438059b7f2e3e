"""The documents of all FB_JsonDomParser of a program, which share the handles of their values."""

from dataclasses import dataclass, field

from fieldrig_devices.iec.tcunit.json.nodes import PLACES, Node, parsed


@dataclass(slots=True)
class Parser:
    """The document of one instance."""

    root: Node | None = None
    has_failed: bool = False
    """True if the last text was not valid."""
    places: int = PLACES


@dataclass(frozen=True, slots=True)
class Place:
    """The place of an iterator in an object or an array; one beyond the last value is the end."""

    node: Node
    index: int

    def value(self) -> Node | None:
        values = self.node.children()
        return values[self.index] if self.index < len(values) else None


@dataclass(slots=True)
class Handles:
    """Numbers for values and places, which programs compare and keep.  A value that is gone has none."""

    _last: int = 0
    _nodes: dict[int, Node] = field(default_factory=dict)
    _places: dict[int, Place] = field(default_factory=dict)
    _known: dict[int, dict[int, int]] = field(default_factory=dict)
    """The number of each place by its index, by that of its value."""

    def new(self) -> int:
        self._last += 1
        return self._last

    def of(self, node: Node | None) -> int:
        """Return the number of a value; 0 for none."""
        if node is None:
            return 0
        if not node.handle:
            node.handle = self.new()
            self._nodes[node.handle] = node
        return node.handle

    def node(self, handle: int) -> Node | None:
        return self._nodes.get(handle)

    def of_place(self, node: Node, index: int) -> int:
        known = self._known.setdefault(self.of(node), {})
        if index not in known:
            known[index] = self.new()
            self._places[known[index]] = Place(node, index)
        return known[index]

    def place(self, handle: int) -> Place | None:
        return self._places.get(handle)

    def forget(self, nodes: list[Node]) -> None:
        """Take the numbers of values back, and of all in them."""
        waiting = list(nodes)
        while waiting:
            node = waiting.pop()
            waiting += node.children()
            if self._nodes.pop(node.handle, None) is not None:
                for number in self._known.pop(node.handle, {}).values():
                    del self._places[number]


def load(parser: Parser, handles: Handles, text: str) -> Node | None:
    """Give a parser a new document; None, and no document, if the text is not valid."""
    replace(parser, handles, parsed(text))
    parser.has_failed = parser.root is None
    return parser.root


def replace(parser: Parser, handles: Handles, root: Node | None) -> None:
    if parser.root is not None:
        handles.forget([parser.root])
    parser.root, parser.has_failed = root, False
