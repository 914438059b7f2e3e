"""The points of any device as nodes: `belt.Position` is the node `Position` below the object `belt`.

Each point is a variable with its unit and text.  Its type is that of its present value: BOOL, LREAL, DINT or LINT, or
STRING.
"""

from collections.abc import Callable, Mapping, Sequence

from fieldrig.device import Point, Value
from fieldrig_bus.opcua.message import AnyValue, Kind, Node
from fieldrig_devices.opcua.tree import UnknownNodeError

_DINT = range(-(2**31), 2**31)


class PointsTree:
    """The tree of nodes that offers the points of a device."""

    def __init__(self, points: Callable[[], Mapping[str, Point]], types: Callable[[str], str] = lambda _: "") -> None:
        """`types` returns the IEC type of the point with this key, if it has one of its own."""
        self._points, self._types = points, types

    def children(self, path: str) -> Sequence[Node]:
        prefix = f"{path}." if path else ""
        names = dict.fromkeys(key[len(prefix) :].partition(".")[0] for key in self._points() if key.startswith(prefix))
        return [node for name in names if name and (node := self.find(prefix + name)) is not None]

    def find(self, path: str) -> Node | None:
        points = self._points()
        parent, _, name = path.rpartition(".")
        has_children = any(key.startswith(f"{path}.") for key in points)
        point = points.get(path)
        if point is None:
            return Node(path, parent, name, Kind.OBJECT, has_children=True) if has_children and path else None
        type_name = self._types(path) or _type_of(point.read())
        is_writable = point.write is not None
        return Node(
            path, parent, name, Kind.VARIABLE, type_name, None, is_writable, has_children, point.unit, point.about
        )

    def read(self, path: str) -> AnyValue:
        return self._point(path).read()

    def write(self, path: str, value: AnyValue) -> None:
        point = self._point(path)
        if point.write is None or isinstance(value, list):
            raise TypeError(f"{path} cannot be written as a whole")
        point.write(value)

    def call(self, path: str, arguments: Sequence[AnyValue]) -> Sequence[AnyValue]:
        raise UnknownNodeError(path)

    def _point(self, path: str) -> Point:
        try:
            return self._points()[path]
        except KeyError:
            raise UnknownNodeError(path) from None


def _type_of(value: Value) -> str:
    match value:
        case bool():
            return "BOOL"
        case int():
            return "DINT" if value in _DINT else "LINT"
        case float():
            return "LREAL"
        case _:
            return "STRING"
