"""The nodes that an application declares, for the PAM's end of the ring."""

from collections.abc import Iterator

from fieldrig_devices.pam.language.items import Declaration, Program
from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pamring.declared import DeclaredNode
from fieldrig_devices.pamring.frames import NodeType


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
