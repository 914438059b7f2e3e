"""Nodes and nodes groups (section 2.2 of the language's digest)."""

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.object_item import ObjectItem, has_error
from fieldrig_devices.pam.objects.site import ApplicationNode, Site
from fieldrig_devices.pamring.frames import NodeType, Trouble


class NodeObject(ObjectItem):
    """A node in programs.  Only a Smart-IO has an error word; a setting gives an ST1 that of its axis (E-03)."""

    def __init__(self, name: str, node: ApplicationNode) -> None:
        super().__init__(name)
        self._node = node

    def ask_error(self) -> bool:
        return bool(self._node.error_word)

    def ask_error_code(self, mask: int | None = None) -> int | bool:
        return has_error(self._node.error_word, mask)


def declare_nodes(declared: Declared, site: Site, count: int) -> list[ObjectItem]:
    """Put the nodes of a declaration on the ring, at consecutive addresses (PAML-022)."""
    group = declared.reference("NODES_GROUP")
    node_type = NodeType[declared.word("TYPE")]
    site.nodes[declared.name] = [
        ApplicationNode(
            declared.name,
            declared.integer("ADDRESS") + index,
            node_type,
            site.port,
            (group, index) if group else None,
        )
        for index in range(count)
    ]
    return [NodeObject(declared.name, node) for node in site.nodes[declared.name]]


def on_trouble(node: ApplicationNode, trouble: Trouble, site: Site) -> None:
    """Keep the error word of a node; the ring's end shows the message."""
    if node.node_type is NodeType.SMART_IO:
        node.error_word = trouble.word
        site.kernel.touched(node.name)
