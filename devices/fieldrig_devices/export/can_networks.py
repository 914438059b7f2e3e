"""The CAN networks of a rig file: its nodes with what their EDS files say, and all of their messages."""

from collections.abc import Iterator, Mapping

from fieldrig.config.rig_file import RigConfig
from fieldrig.traces.names import Member, members_of
from fieldrig_devices.canopen.cob_id import BIT_30
from fieldrig_devices.canopen.described import nodes_of
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.names import CanopenNames, KnownNode, namer
from fieldrig_devices.canopen.signals import Binding, bind
from fieldrig_devices.export import services
from fieldrig_devices.export.masters import configure, declared_pdos, managed
from fieldrig_devices.export.network import Network, free_name
from fieldrig_devices.export.objects import Objects
from fieldrig_devices.export.pdos import RECEIVED, SENT, pdos

CAN = "can"
SYNC_COB_ID, SYNC_OVERFLOW = 0x1005, 0x1019
MASTER = "master"
"""The node at the other end where the rig has no master."""


def networks(config: RigConfig) -> Iterator[Network]:
    """Yield the CAN networks of a rig, in the order of its file."""
    for name, entry in config.buses.items():
        if entry.bus.family == CAN:
            yield _network(config, name)


def _network(config: RigConfig, bus: str) -> Network:
    members = members_of(config, bus)
    named = namer(config.buses[bus].bus, members)
    assert isinstance(named, CanopenNames), "it is that of CAN"
    slaves = {slave.settings.node_id: slave for slave in managed(members)}
    known = {node_id: slave.known for node_id, slave in slaves.items()} | dict(named.nodes)
    for node_id, slave in slaves.items():
        if (dictionary := known[node_id].dictionary) is not None:
            configure(dictionary, slave.settings)
    names = _names(known)
    network, master = Network(bus), _master(members)
    network.nodes[master] = "master"
    network.nodes |= {name: _about(known[node_id], node_id) for node_id, name in names.items()}
    bound = _bindings(members, known)
    objects = {
        node_id: Objects(node.dictionary, bound.get(node_id, ()))
        for node_id, node in known.items()
        if node.dictionary is not None
    }
    for kind in (SENT, RECEIVED):  # a PDO of two nodes is that of its producer
        for node_id, of in objects.items():
            network.add(pdos(kind, names[node_id], of, master))
    for node_id in slaves.keys() - objects.keys():
        network.add(declared_pdos(names[node_id], slaves[node_id].settings, master))
    for node_id, node in known.items():
        network.add(services.of_node(names[node_id], node_id, node.dictionary, master))
    counts_sync = any(of.dictionary.number(SYNC_OVERFLOW, 0) for of in objects.values())
    sync_by = _sync_producer(known, names, master)
    network.add(services.of_network(names, master, sync_by, counts_sync=counts_sync))
    return network


def _names(known: Mapping[int, KnownNode]) -> dict[int, str]:
    """Return the names of the nodes by node-ID; those of a device with several nodes have the node-ID in them."""
    devices = [node.name for node in known.values()]
    names: dict[int, str] = {}
    for node_id, node in known.items():
        wanted = node.name if devices.count(node.name) == 1 else f"{node.name}_{node_id}"
        names[node_id] = free_name(wanted, {MASTER, *(name.lower() for name in names.values())})
    return names


def _master(members: list[Member]) -> str:
    """Return the name of the node that masters nodes here: a device of the rig, or one outside."""
    masters = [member.entry.name for member in members if member.claims("master of node-ID")]
    return free_name(masters[0] if len(masters) == 1 else MASTER, ())


def _about(node: KnownNode, node_id: int) -> str:
    return f"node-ID {node_id}{'' if node.dictionary is not None else ', without an EDS'}"


def _bindings(members: list[Member], known: Mapping[int, KnownNode]) -> dict[int, tuple[Binding, ...]]:
    found: dict[int, tuple[Binding, ...]] = {}
    for member in members:
        for node in nodes_of(member.entry.settings):
            named = None if node.node_id is None else known.get(node.node_id)
            if node.node_id is not None and named is not None and named.dictionary is not None:
                found[node.node_id] = tuple(bind(named.dictionary, node.signals))
    return found


def _sync_producer(known: Mapping[int, KnownNode], names: Mapping[int, str], master: str) -> str:
    producers = (names[node_id] for node_id, node in known.items() if _produces_sync(node.dictionary))
    return next(producers, master)


def _produces_sync(dictionary: Dictionary | None) -> bool:
    return dictionary is not None and bool(dictionary.number(SYNC_COB_ID, 0) & BIT_30)
