"""Calls of methods of devices: arguments from the client to the device, and results back.

Source: OPC 10000-4, 5.12.2: if arguments are not accepted, the result is BadInvalidArgument with a status for each.
"""

from collections.abc import Sequence
from typing import Final

from asyncua import ua

from fieldrig_bus.opcua import message
from fieldrig_bus.opcua.address_space import AddressSpace, node_id_of
from fieldrig_bus.opcua.devices import Devices
from fieldrig_bus.opcua.mapping import STATUS_CODES, WrongValueError, from_variant, to_variant
from fieldrig_bus.opcua.message import AnyValue, Argument, Kind, Node, Outcome, Status

BAD_METHOD_INVALID: Final[int] = ua.StatusCodes.BadMethodInvalid
BAD_ARGUMENTS_MISSING: Final[int] = ua.StatusCodes.BadArgumentsMissing
BAD_TOO_MANY_ARGUMENTS: Final[int] = ua.StatusCodes.BadTooManyArguments


async def call(space: AddressSpace, devices: Devices, asked: ua.CallMethodRequest, node: Node) -> ua.CallMethodResult:
    """Call a method of a device."""
    index, given = asked.MethodId.NamespaceIndex, asked.InputArguments or []
    if asked.ObjectId != node_id_of(node.parent, index):
        return refused(BAD_METHOD_INVALID)
    if len(given) != len(node.arguments):
        return refused(BAD_ARGUMENTS_MISSING if len(given) < len(node.arguments) else BAD_TOO_MANY_ARGUMENTS)
    device = space.device(asked.MethodId)
    values, statuses = await _arguments(space, device, node.arguments, given)
    if any(status is not Status.GOOD for status in statuses):
        outcome = Outcome(Status.WRONG_ARGUMENTS, arguments=tuple(statuses))
    else:
        outcome = await devices.call(device, node.path, values)
    result = refused(STATUS_CODES[outcome.status])
    result.InputArgumentResults = [ua.StatusCode(STATUS_CODES[status]) for status in outcome.arguments]
    if outcome.status is Status.GOOD:
        result.OutputArguments = [
            _result(argument, value, index) for argument, value in zip(node.results, outcome.results, strict=False)
        ]
    return result


def refused(code: int) -> ua.CallMethodResult:
    """Return a result without values; the code may be Good."""
    result = ua.CallMethodResult(InputArgumentResults=[], OutputArguments=[])
    result.StatusCode = ua.StatusCode(code)
    return result


async def _arguments(
    space: AddressSpace, device: str, arguments: Sequence[Argument], given: Sequence[ua.Variant]
) -> tuple[list[AnyValue], list[Status]]:
    """Return the values for the device, with a status for each argument."""
    values, statuses, named = list[AnyValue](), list[Status](), None
    for argument, variant in zip(arguments, given, strict=True):
        value: AnyValue = ""
        status = Status.GOOD
        try:
            match argument.type:
                case message.NODE:
                    named = await _node(space, device, variant)
                    value = named.path
                case message.VALUE:
                    value = _value_of(named, variant)
                case _:
                    value = from_variant(_typed(argument, variant), variant)
        except WrongValueError as cause:
            status = cause.status
        values.append(value)
        statuses.append(status)
    return values, statuses


async def _node(space: AddressSpace, device: str, variant: ua.Variant) -> Node:
    """Return the node of the device that an argument names; a null NodeId is the device itself."""
    node_id = variant.Value
    if not isinstance(node_id, ua.NodeId):
        raise WrongValueError(Status.TYPE_MISMATCH)
    if node_id.is_null():
        return _DEVICE
    if node_id not in space or space.device(node_id) != device:
        raise WrongValueError(Status.UNKNOWN)
    await space.ensure(node_id)
    node = space.node(node_id)
    if node is None:
        raise WrongValueError(Status.UNKNOWN)
    return node


_DEVICE: Final = Node("", "", "", Kind.OBJECT)


def _value_of(named: Node | None, variant: ua.Variant) -> AnyValue:
    """Return the value for a variable.  Without one, the argument that names it is what is wrong."""
    return "" if named is None or named.kind is not Kind.VARIABLE else from_variant(named, variant)


def _typed(argument: Argument, variant: ua.Variant) -> Node:
    """Return an argument as a variable, which has as many elements as the client gives."""
    length = len(variant.Value) if isinstance(variant.Value, list) else 0
    return Node("", "", argument.name, type=argument.type, length=length if argument.is_array else None)


def _result(argument: Argument, value: AnyValue, index: int) -> ua.Variant:
    if argument.type != message.NODE:
        return to_variant(_typed(argument, ua.Variant(value)), value)
    if isinstance(value, list):
        return ua.Variant([node_id_of(str(path), index) for path in value], ua.VariantType.NodeId, is_array=True)
    return ua.Variant(node_id_of(str(value), index), ua.VariantType.NodeId)
