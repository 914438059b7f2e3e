"""The nodes of a MAx-4 for OPC UA: variables of the program, configuration objects with their parameters, methods.

Source: PacDrive manual 6873-6887, 6941-6943 (digest PD-284): OPC gives direct access to the data of the controller.
The manual's server speaks OPC DA on a PC; ours is OPC UA, with a node for each parameter and variable.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

from fieldrig.link import Link
from fieldrig_bus.opcua.message import AnyValue, Kind, Node, OpcUaMessage
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.max4.configuration.tree import Object, ObjectTree, Parameter, Type
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.opcua.face import OpcUaFace
from fieldrig_devices.opcua.forcing import forcing
from fieldrig_devices.opcua.methods import Method, MethodsTree
from fieldrig_devices.opcua.symbols import SymbolsTree
from fieldrig_devices.opcua.tree import NodeTree, Trees, UnknownNodeError

METHODS: Final = {
    "start": "start the program",
    "stop": "stop the program",
    "reset": "reset the program to its first state",
    "quit": "acknowledge the diagnoses of the controller and its axes",
}
"""Commands of an operator that are methods."""


class ObjectNodes:
    """Configuration objects and parameters: `belt` is an object, and `belt.Position` a variable below it."""

    def __init__(self, tree: ObjectTree) -> None:
        self._objects = {_name(known).casefold(): known for known in tree.objects()}
        self._root = tree.root

    def children(self, path: str) -> Sequence[Node]:
        if not path:
            return [self._object(self._root)]
        owner = self._objects.get(path.casefold())
        if owner is None:
            return []
        own = [_parameter(owner, parameter) for parameter in owner.parameters]
        return [*own, *(self._object(child) for child in owner.children)]

    def find(self, path: str) -> Node | None:
        owner = self._objects.get(path.casefold())
        if owner is not None:
            return self._object(owner)
        pair = self._pair(path)
        return None if pair is None else _parameter(*pair)

    def read(self, path: str) -> AnyValue:
        return self._known(path).shown

    def write(self, path: str, value: AnyValue) -> None:
        if isinstance(value, list):
            raise TypeError(f"{path} is no array")
        self._known(path).set(value)

    def call(self, path: str, arguments: Sequence[AnyValue]) -> Sequence[AnyValue]:
        raise UnknownNodeError(path)

    def _known(self, path: str) -> Parameter:
        pair = self._pair(path)
        if pair is None:
            raise UnknownNodeError(path)
        return pair[1]

    def _pair(self, path: str) -> tuple[Object, Parameter] | None:
        """Return an object and the parameter of it that has this path."""
        symbol, _, name = path.rpartition(".")
        owner = self._objects.get(symbol.casefold())
        if owner is None:
            return None
        named = (parameter for parameter in owner.parameters if parameter.name.casefold() == name.casefold())
        return next(((owner, parameter) for parameter in named), None)

    def _object(self, owner: Object) -> Node:
        parent = "" if owner is self._root or owner.parent is None else _name(owner.parent)
        about = owner.type_name if owner.type_name != owner.name else ""
        return Node(_name(owner), parent, _name(owner), Kind.OBJECT, has_children=True, about=about)


def _name(owner: Object) -> str:
    return owner.symbol or owner.name


def _parameter(owner: Object, parameter: Parameter) -> Node:
    has_range = parameter.type is not Type.STRING and (parameter.low, parameter.high) != (
        parameter.type.low,
        parameter.type.high,
    )
    return Node(
        f"{_name(owner)}.{parameter.name}",
        _name(owner),
        parameter.name,
        Kind.VARIABLE,
        parameter.type.text,
        is_writable=parameter.is_writable,
        unit=parameter.unit,
        about=parameter.about,
        low=parameter.low if has_range else None,
        high=parameter.high if has_range else None,
    )


class OpcUaNodes:
    """The OPC UA face of a controller."""

    def __init__(
        self,
        name: str,
        about: str,
        controller: Controller,
        do: Callable[[str], None],
        present: Callable[[], LoadedProgram | None],
        link: Link[OpcUaMessage],
    ) -> None:
        """`do` carries out a command of an operator, and `present` returns the program that is loaded."""
        self._controller, self._present = controller, present
        methods = {word: Method(about, partial(do, word)) for word, about in METHODS.items()}
        self._methods = MethodsTree({**methods, **forcing(self._program)})
        self._face = OpcUaFace(name, about, link, self._nodes)
        self._objects: tuple[ObjectTree, ObjectNodes] | None = None
        controller.on_boot(self.changed)

    def changed(self) -> None:
        """Offer the nodes again: after a boot, a download and an online change."""
        self._face.offer()

    def _program(self) -> SymbolsTree | None:
        program = self._present()
        return None if program is None else SymbolsTree(program.runtime.symbols, program.runtime)

    def _nodes(self) -> NodeTree:
        tree = self._controller.tree
        if self._objects is None or self._objects[0] is not tree:
            self._objects = tree, ObjectNodes(tree)
        program = self._program()
        return Trees([*([program] if program is not None else []), self._objects[1], self._methods])
