"""A system of components, each with its ring nodes, and their peripherals (section 1.2 of the manual)."""

import pytest
from pam_objects import Bench
from pam_programs import HEADER

from fieldrig_devices.pam.declared_nodes import declared_nodes
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pamring.frames import InputItem, NodeType

SYSTEM = (
    HEADER
    + """
NODES_GROUP NGR_Heads; NUMBER = 2; END
NODE NOD_Drive; NODES_GROUP = NGR_Heads; ADDRESS = 1; TYPE = ST1; END
NODE NOD_Io; NODES_GROUP = NGR_Heads; ADDRESS = 11; TYPE = SMART_IO; END
NODE NOD_Desk; ADDRESS = 21; TYPE = SMART_IO; END
AXIS AXI_Head; NODE = NOD_Drive; PULSES_PER_UNIT = 1; TRAVEL_SPEED = 1; ACCELERATION = 1; INITIAL_POSITION = 0;
  POSITION_PERIOD = 360; END
BINARY_INPUT SBI_Mark; NODE = NOD_Io; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
"""
)


@pytest.mark.manual("PAML-001")
def test_a_component_has_nodes_and_a_node_has_peripherals() -> None:
    declared = declared_nodes(checked(SYSTEM, "x")[0])
    assert [(node.node_type, list(node.addresses), node.group) for node in declared] == [
        (NodeType.ST1, [1, 2], "NGR_Heads"),
        (NodeType.SMART_IO, [11, 12], "NGR_Heads"),
        (NodeType.SMART_IO, [21], ""),
    ]
    objects = Bench(SYSTEM).objects
    peripherals = {node.address: [type(item) for item in node.items] for node in objects.nodes}
    assert [peripherals[address] for address in (11, 12, 21)] == [[InputItem], [InputItem], []]
    assert [len(objects.items[name]) for name in ("AXI_Head", "SBI_Mark")] == [2, 2]
    objects.leave_out([12])  # a node of the second component, which is then without its drive as well
    assert [objects.is_active(name, index) for name in ("AXI_Head", "SBI_Mark") for index in (0, 1)] == [
        True,
        False,
    ] * 2
