"""The nodes that an application declares, for the PAM's end of the ring."""

from collections.abc import Iterator, Mapping
from typing import Final

from fieldrig_devices.pam.language.items import Declaration, Program
from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.described import DescribedNode, DescribedObject
from fieldrig_devices.pamring.frames import NodeType

ITEMS: Final = frozenset({
    "AXIS", "BINARY_INPUT", "DIGITAL_INPUT", "COUNTER_INPUT", "KEY_INPUT", "BINARY_OUTPUT", "DIGITAL_OUTPUT",
    "ANALOG_OUTPUT", "LED_OUTPUT", "D7SEG_OUTPUT", "DC_MOTOR",
})  # fmt: skip
"""Classes of objects that are items of a node; an encoder is read by its address."""


def declared_nodes(program: Program) -> list[DeclaredNode]:
    """Return the NODE declarations in the order of the text, numbered from 0."""
    groups: dict[str, int] = {}
    nodes: list[DeclaredNode] = []
    for declared in declarations(program):
        if declared.kind == "NODES_GROUP":
            groups[declared.name] = declared.integer("NUMBER")
        elif declared.kind == "NODE":
            group = declared.reference("NODES_GROUP")
            count = groups[group] if group else declared.integer("NUMBER", 1)
            node_type = NodeType[declared.word("TYPE")]
            nodes.append(DeclaredNode(len(nodes), node_type, declared.integer("ADDRESS"), count, group))
    return nodes


def declarations(program: Program) -> Iterator[Declared]:
    """Yield the objects of an application that are described by parameters, in the order of the text."""
    return (Declared(item) for item in program.items if isinstance(item, Declaration))


def described_nodes(program: Program) -> Mapping[int, DescribedNode]:
    """Return the nodes by their addresses, with their objects in the order in which the PAM numbers its items."""
    owners: dict[str, str] = {}
    objects: dict[str, list[DescribedObject]] = {}
    nodes: list[str] = []
    for declared in declarations(program):
        if declared.kind == "NODE":
            nodes.append(declared.name)
        owner = declared.reference("NODE") or owners.get(declared.reference("ZERO"), "")  # of a DC motor
        if declared.kind in ITEMS and owner:
            owners[declared.name] = owner
            units = declared.number("PULSES_PER_UNIT") if declared.kind == "AXIS" else 0.0
            objects.setdefault(owner, []).append(DescribedObject(declared.name, declared.kind, units))
    return {
        address: DescribedNode(name, tuple(objects.get(name, ())))
        for name, node in zip(nodes, declared_nodes(program), strict=True)
        for address in node.addresses
    }
