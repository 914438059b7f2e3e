"""Requests that ask for nothing, or for what is not there, get the status of OPC 10000-4 instead of an empty answer.

Source: OPC 10000-4, 5.9.2 (Browse), 5.9.4 (TranslateBrowsePathsToNodeIds), 5.12.2 (Call), and BadNothingToDo of each
service with a list.
"""

import re
from collections.abc import Mapping, Sized
from enum import EnumType
from typing import Any, Final

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.server.address_space import AddressSpace

BAD_NOTHING_TO_DO: Final[int] = ua.StatusCodes.BadNothingToDo
BAD_BROWSE_DIRECTION: Final[int] = ua.StatusCodes.BadBrowseDirectionInvalid
BAD_REFERENCE_TYPE: Final[int] = ua.StatusCodes.BadReferenceTypeIdInvalid
BAD_BROWSE_NAME: Final[int] = ua.StatusCodes.BadBrowseNameInvalid
BAD_NODE: Final[int] = ua.StatusCodes.BadNodeIdUnknown
BAD_DECODING: Final[int] = ua.StatusCodes.BadDecodingError
BAD_METHOD: Final[int] = ua.StatusCodes.BadMethodInvalid
_NO_MEMBER: Final = re.compile(r".* is not a valid (\w+)")
_WRONG_MEMBERS: Final[Mapping[str, int]] = {
    "MonitoringMode": ua.StatusCodes.BadMonitoringModeInvalid,
    "TimestampsToReturn": ua.StatusCodes.BadTimestampsToReturnInvalid,
    "BrowseDirection": BAD_BROWSE_DIRECTION,
    "DataChangeTrigger": ua.StatusCodes.BadMonitoredItemFilterInvalid,
    "FilterOperator": ua.StatusCodes.BadMonitoredItemFilterInvalid,
}
"""The status of a number that one of these enumerations lacks; that of any other one is BadDecodingError."""
_DIRECTIONS: Final = frozenset({ua.BrowseDirection.Forward, ua.BrowseDirection.Inverse, ua.BrowseDirection.Both})


def check_some(items: Sized | None) -> None:
    """Raise ServiceError for a request whose list is empty."""
    if not items:
        raise ServiceError(BAD_NOTHING_TO_DO)


def wrong_member(cause: ValueError) -> int:
    """Return the status of a request in which the library has found a number that an enumeration lacks; else 0."""
    match = _NO_MEMBER.fullmatch(str(cause))
    if match is None or not isinstance(getattr(ua, match[1], None), EnumType):
        return 0
    return _WRONG_MEMBERS.get(match[1], BAD_DECODING)


def with_status(result: Any, status: int) -> Any:
    """Return a result without values that says what is wrong."""
    result.StatusCode = ua.StatusCode(status)
    return result


def wrong_browse(asked: ua.BrowseDescription, nodes: AddressSpace) -> int:
    """Return the status of a node that cannot be browsed like this; 0 if it can."""
    if nodes.get(asked.NodeId) is None:
        return BAD_NODE
    if asked.BrowseDirection not in _DIRECTIONS:
        return BAD_BROWSE_DIRECTION
    if asked.ReferenceTypeId.is_null():
        return 0  # all references
    return 0 if _class(asked.ReferenceTypeId, nodes) is ua.NodeClass.ReferenceType else BAD_REFERENCE_TYPE


def wrong_path(path: ua.BrowsePath, nodes: AddressSpace) -> int:
    """Return the status of a path that leads nowhere whatever the names are; 0 if it may lead somewhere."""
    elements = path.RelativePath.Elements
    if not elements:
        return BAD_NOTHING_TO_DO
    if any(not element.TargetName or not element.TargetName.Name for element in elements):
        return BAD_BROWSE_NAME
    return 0 if nodes.get(path.StartingNode) is not None else BAD_NODE


def wrong_call(asked: ua.CallMethodRequest, nodes: AddressSpace) -> int:
    """Return the status of a call of what is no method, or of an object that is not there; 0 for any other."""
    if nodes.get(asked.ObjectId) is None:
        return BAD_NODE
    return 0 if _class(asked.MethodId, nodes) is ua.NodeClass.Method else BAD_METHOD


def _class(node_id: ua.NodeId, nodes: AddressSpace) -> ua.NodeClass | None:
    """Return the class of a node; None if it is not there."""
    data = nodes.get(node_id)
    value = data.attributes[ua.AttributeIds.NodeClass].value if data is not None else None
    return ua.NodeClass(value.Value.Value) if value is not None and value.Value is not None else None
