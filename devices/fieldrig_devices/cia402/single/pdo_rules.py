"""When a master may change the mapping of the PDOs, for drives that are stricter than CiA 301."""

from collections.abc import Callable, Iterator

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.node import CanopenNode
from fieldrig_devices.canopen.service import State
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.cia402.single.personality import MappingRule

FIRST, SECOND, MOST = 0x1600, 0x1A00, 0x200


def apply(rule: MappingRule, node: CanopenNode) -> None:
    """Have the mapping objects refuse what the drive does not allow."""
    if rule is MappingRule.FREE:
        return
    for variable in _mappings(node):
        variable.writer = _guarded(rule, node, variable.writer or variable.set)


def _mappings(node: CanopenNode) -> Iterator[Variable]:
    return (variable for variable in node.dictionary if (variable.index & ~(MOST - 1)) in (FIRST, SECOND))


def _guarded(rule: MappingRule, node: CanopenNode, write: Callable[[bytes], None]) -> Callable[[bytes], None]:
    def guarded(data: bytes) -> None:
        if rule is MappingRule.FIXED:
            raise Abort(Code.READ_ONLY)
        if node.nmt.state is not State.PRE_OPERATIONAL:
            raise Abort(Code.DEVICE_STATE)
        write(data)

    return guarded
