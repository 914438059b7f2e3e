"""Methods without arguments as nodes below the device: `start()`, `stop()`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from fieldrig_bus.opcua.message import AnyValue, Kind, Node
from fieldrig_devices.opcua.tree import UnknownNodeError


@dataclass(frozen=True, slots=True)
class Method:
    about: str
    call: Callable[[], None]
    """Raises ValueError, with the reason, if it is not possible now."""


class MethodsTree:
    def __init__(self, methods: Mapping[str, Method]) -> None:
        self._methods = {f"{name}()": method for name, method in methods.items()}

    def children(self, path: str) -> Sequence[Node]:
        return [self._node(own) for own in self._methods] if not path else []

    def find(self, path: str) -> Node | None:
        return self._node(path) if path in self._methods else None

    def read(self, path: str) -> AnyValue:
        raise UnknownNodeError(path)

    def write(self, path: str, value: AnyValue) -> None:
        raise UnknownNodeError(path)

    def call(self, path: str) -> None:
        if path not in self._methods:
            raise UnknownNodeError(path)
        self._methods[path].call()

    def _node(self, path: str) -> Node:
        return Node(path, "", path.removesuffix("()"), Kind.METHOD, about=self._methods[path].about)
