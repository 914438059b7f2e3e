"""The parameters of a browse request besides the nodes: how many references, which of their fields, and which view.

Source: OPC 10000-4, 5.9.2 (Browse), 5.9.3 (BrowseNext) and 7.9 (ContinuationPoint).
"""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from asyncua import ua
from asyncua.common.utils import ServiceError

MOST_POINTS: Final = 16
"""Continuation points of a session."""
_EMPTY: Final[dict[int, dict[str, Any]]] = {
    1 << 0: {"ReferenceTypeId": ua.NodeId()},
    1 << 1: {"IsForward": False},
    1 << 2: {"NodeClass": ua.NodeClass.Unspecified},
    1 << 3: {"BrowseName": ua.QualifiedName()},
    1 << 4: {"DisplayName": ua.LocalizedText()},
    1 << 5: {"TypeDefinition": ua.ExpandedNodeId()},
}
"""Fields that a client does without, by their bits of the result mask (table 33)."""
_ALL_FIELDS: Final = sum(_EMPTY)


def check_view(params: ua.BrowseParameters) -> None:
    """Raise ServiceError for a view, because the server has none."""
    if params.View.ViewId != ua.NodeId():
        raise ServiceError(ua.StatusCodes.BadViewIdUnknown)


def with_fields(references: Sequence[ua.ReferenceDescription], mask: int) -> list[ua.ReferenceDescription]:
    """Return the references with the fields that the client wants."""
    if mask & _ALL_FIELDS == _ALL_FIELDS:
        return list(references)
    empty = {name: value for bit, fields in _EMPTY.items() if not mask & bit for name, value in fields.items()}
    return [replace(reference, **empty) for reference in references]


class Continuations:
    """The references of a session that did not fit into an answer, by their continuation points."""

    def __init__(self) -> None:
        self._rest: OrderedDict[bytes, tuple[list[ua.ReferenceDescription], int]] = OrderedDict()
        self._count = 0

    def first(self, result: ua.BrowseResult, most: int) -> None:
        """Leave the first `most` references in a result, and keep the others; 0: the server sets no limit."""
        references = result.References
        if most and len(references) > most:
            result.References = references[:most]
            result.ContinuationPoint = self._keep(references[most:], most)

    def _keep(self, rest: list[ua.ReferenceDescription], most: int) -> bytes:
        self._count += 1
        point = self._count.to_bytes(4, "little")
        self._rest[point] = rest, most
        if len(self._rest) > MOST_POINTS:
            self._rest.popitem(last=False)  # that client asks too late, and gets BadContinuationPointInvalid
        return point

    def next(self, params: ua.BrowseNextParameters) -> list[ua.BrowseResult]:
        """Return what follows, or nothing for points that are released (5.9.3.2)."""
        results = [self._next(point) for point in params.ContinuationPoints if not params.ReleaseContinuationPoints]
        for point in params.ContinuationPoints:
            self._rest.pop(point, None)
        return results

    def _next(self, point: bytes) -> ua.BrowseResult:
        result = ua.BrowseResult()
        rest, most = self._rest.pop(point, ([], 0))
        if not rest:
            result.StatusCode = ua.StatusCode(ua.StatusCodes.BadContinuationPointInvalid)
            return result
        result.References = rest
        self.first(result, most)
        return result
