"""The nodes that an application declares, compared with those on the ring (PAML-020 to PAML-028).

A NODE with NUMBER has consecutive addresses.  So has one of a NODES_GROUP, whose members may be missing: the component
of a missing member is ignored with all of its nodes (PAML-007).
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from fieldrig_devices.pamring import messages
from fieldrig_devices.pamring.frames import NodeType
from fieldrig_devices.pamring.messages import RING_MODE, Message


@dataclass(frozen=True, slots=True)
class DeclaredNode:
    """One NODE declaration."""

    number: int
    """Its ID in the listing of the application."""
    node_type: NodeType
    address: int
    count: int = 1
    """NUMBER, or that of its NODES_GROUP."""
    group: str = ""
    """The name of its NODES_GROUP."""

    @property
    def addresses(self) -> range:
        return range(self.address, self.address + self.count)


def types_of(nodes: Iterable[DeclaredNode]) -> dict[int, NodeType]:
    """The types of the declared addresses."""
    return {address: node.node_type for node in nodes for address in node.addresses}


def active_addresses(nodes: Sequence[DeclaredNode], present: Collection[int]) -> frozenset[int]:
    """The declared addresses that are on the ring, without those of components that lack a node."""
    lacking = {
        (node.group, component)
        for node in nodes
        for component, address in enumerate(node.addresses)
        if address not in present
    }
    return frozenset(
        address
        for node in nodes
        for component, address in enumerate(node.addresses)
        if address in present and (node.group, component) not in lacking
    )


def ring_mistakes(
    nodes: Sequence[DeclaredNode], addresses: Sequence[int], types: Mapping[int, NodeType], most: int
) -> Iterator[Message]:
    """Yield what is wrong with the ring as a whole: with its addresses, and with the types of the nodes that answered.

    The order is that of table 12-7, so that the first one, which a master reads, names a node wherever one is wrong.

    `most` is the number of nodes for which the cycle has time.
    """
    declared, present = types_of(nodes), set(addresses)
    tolerated = {address for node in nodes if node.group for address in node.addresses}
    for address in sorted(present - declared.keys()):
        yield messages.UNDECLARED_NODE, (RING_MODE, address, 0)
    for address in sorted(declared.keys() - present - tolerated):
        yield messages.NODE_MISSING, (RING_MODE, address, 0)
    for address in sorted(declared.keys() & types.keys()):
        if types[address] != declared[address]:
            yield messages.WRONG_TYPE, (RING_MODE, address, 0)
    for address in sorted(declared.keys() & present - types.keys()):
        yield messages.NODE_NOT_READY, (RING_MODE, address, 0)
    if len(addresses) > most:
        yield messages.TOO_MANY_NODES, (most, len(addresses), 0)
    if len(present) < len(addresses):
        yield messages.WRONG_COUNT, (RING_MODE, len(addresses), 0)


def nodes_without_items(nodes: Sequence[DeclaredNode], present: Collection[int]) -> list[Message]:
    """A message for each NODE declaration of which no peripheral is on the ring."""
    return [
        (messages.NODE_WITHOUT_ITEMS, (node.number, node.count, node.address))
        for node in nodes
        if not any(address in present for address in node.addresses)
    ]
