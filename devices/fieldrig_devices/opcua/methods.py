"""Methods as nodes below the device: `start()`, `force()`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from fieldrig_bus.opcua.message import AnyValue, Argument, Kind, Node
from fieldrig_devices.opcua.tree import UnknownNodeError


@dataclass(frozen=True, slots=True)
class Method:
    about: str
    call: Callable[..., Sequence[AnyValue] | None]
    """Takes the arguments, and returns the results.  WrongArgumentsError; ValueError, with the reason, if it is not
    possible now."""
    arguments: tuple[Argument, ...] = ()
    results: tuple[Argument, ...] = ()
    is_writable: bool = True
    """False for a method that changes nothing, so that users who may only read can call it."""


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

    def call(self, path: str, arguments: Sequence[AnyValue]) -> Sequence[AnyValue]:
        if path not in self._methods:
            raise UnknownNodeError(path)
        return self._methods[path].call(*arguments) or ()

    def _node(self, path: str) -> Node:
        method, name = self._methods[path], path.removesuffix("()")
        return Node(
            path,
            "",
            name,
            Kind.METHOD,
            is_writable=method.is_writable,
            about=method.about,
            arguments=method.arguments,
            results=method.results,
        )
