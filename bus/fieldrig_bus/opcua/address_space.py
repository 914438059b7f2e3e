"""The nodes of devices in the address space of the server, added when a client first asks for them.

A device is an object below `Objects`, in a namespace of its own, `urn:fieldrig:RIG:DEVICE`; the first device of the rig
file has index 2.  Its nodes have its paths as identifiers, so a NodeId is the same after a restart, a download and an
online change.  When a device offers its nodes again, the nodes that clients have seen are compared with the new ones,
and a GeneralModelChangeEvent reports the differences.  Sessions and subscriptions stay.
"""

import logging
from typing import Final

from asyncua import Server, ua

from fieldrig_bus.opcua.devices import Devices
from fieldrig_bus.opcua.mapping import described, engineering_units, mapped, value_range
from fieldrig_bus.opcua.message import LONGEST_PATH, Kind, Node

log = logging.getLogger(__name__)

FIRST_NAMESPACE: Final = 2
"""Index of the namespace of the first device; 0 is that of OPC UA, and 1 that of the server."""
ROOT: Final = 1
"""Identifier of the object of a device."""
_O: Final = ua.ObjectIds
_READ: Final = 1 << ua.AccessLevel.CurrentRead
_WRITE: Final = 1 << ua.AccessLevel.CurrentWrite
_CLASSES: Final = {
    Kind.OBJECT: ua.NodeClass.Object,
    Kind.VARIABLE: ua.NodeClass.Variable,
    Kind.METHOD: ua.NodeClass.Method,
}


class AddressSpace:
    def __init__(self, server: Server, devices: Devices) -> None:
        self._server, self._devices = server, devices
        self._names: list[str] = []
        self._nodes: dict[ua.NodeId, Node] = {}
        """The nodes that have been added."""
        self._browsed: dict[ua.NodeId, list[ua.NodeId]] = {}
        """The children of the nodes that have been browsed."""

    def __contains__(self, node_id: ua.NodeId) -> bool:
        """True for nodes that belong to a device, whether they have been added or not."""
        index = node_id.NamespaceIndex - FIRST_NAMESPACE
        return bool(0 <= index < len(self._names))

    def device(self, node_id: ua.NodeId) -> str:
        index: int = node_id.NamespaceIndex - FIRST_NAMESPACE
        return self._names[index]

    def node(self, node_id: ua.NodeId) -> Node | None:
        return self._nodes.get(node_id)

    def add_device(self, name: str, about: str, index: int) -> None:
        """Add the object of a device, whose namespace is already in the NamespaceArray as number `index`."""
        while len(self._names) <= index - FIRST_NAMESPACE:
            self._names.append("")
        self._names[index - FIRST_NAMESPACE] = name
        node = Node("", "", name, Kind.OBJECT, has_children=True, about=about)
        self._add(node_id_of("", index), node, ua.NodeId(_O.ObjectsFolder), _O.Organizes)

    def is_known(self, name: str) -> bool:
        return name in self._names

    # ---- on request of a client

    async def ensure(self, node_id: ua.NodeId) -> None:
        """Add the node and its parents, if the device has it."""
        if node_id not in self or node_id in self._nodes or _is_property(node_id):
            return
        path = str(node_id.Identifier)
        node = await self._devices.find(self.device(node_id), path) if len(path) <= LONGEST_PATH else None
        if node is not None and node_id.Identifier == node.path:
            parent = node_id_of(node.parent, node_id.NamespaceIndex)
            await self.ensure(parent)
            if parent in self._nodes and node_id not in self._nodes:
                self._add(node_id, node, parent)

    async def browse(self, node_id: ua.NodeId) -> None:
        """Add the node and its children."""
        await self.ensure(node_id)
        node = self._nodes.get(node_id)
        if node is None or not node.has_children or node_id in self._browsed:
            return
        children = await self._devices.children(self.device(node_id), node.path)
        if children is None:
            return  # the next client may have more luck
        own = self._browsed[node_id] = []
        for child in children:
            child_id = node_id_of(child.path, node_id.NamespaceIndex)
            if child_id not in self._nodes:
                self._add(child_id, child, node_id)
            own.append(child_id)

    # ---- after a change of the device

    async def update(self, name: str) -> list[ua.ModelChangeStructureDataType]:
        """Compare the nodes that are known of a device with those that it has now, and return the changes."""
        index = self._names.index(name) + FIRST_NAMESPACE
        changes: list[ua.ModelChangeStructureDataType] = []
        for node_id in [known for known in self._nodes if known.NamespaceIndex == index and known.Identifier != ROOT]:
            old = self._nodes.get(node_id)
            new = await self._devices.find(name, str(node_id.Identifier)) if old is not None else None
            if old is None or new == old:
                continue
            self._remove(node_id)
            verb = ua.ModelChangeStructureVerbMask.NodeDeleted
            if new is not None:
                self._add(node_id, new, node_id_of(new.parent, index))
                verb = ua.ModelChangeStructureVerbMask.DataTypeChanged
            changes.append(_change(node_id, verb))
        for parent in [known for known in self._browsed if known.NamespaceIndex == index]:
            before = set(self._browsed.pop(parent))
            await self.browse(parent)
            added = [reference for reference in self._browsed.get(parent, []) if reference not in before]
            changes += [_change(reference, ua.ModelChangeStructureVerbMask.NodeAdded) for reference in added]
        # No client has seen the rest of the nodes, but one may have seen that they were missing.
        return changes or [_change(node_id_of("", index), ua.ModelChangeStructureVerbMask.ReferenceAdded)]

    def _remove(self, node_id: ua.NodeId) -> None:
        """Remove a node; subscriptions to it stay, and get their values when it comes back."""
        self._nodes.pop(node_id, None)
        self._browsed.pop(node_id, None)
        space = self._server.iserver.aspace
        for own in (
            node_id,
            *(ua.NodeId(f"{node_id.Identifier}{suffix}", node_id.NamespaceIndex) for suffix in _SUFFIXES),
        ):
            if own not in space:
                continue
            for reference in list(space[own].references):
                if not reference.IsForward and reference.NodeId in space:
                    parent = space[reference.NodeId]
                    parent.references[:] = [reference for reference in parent.references if reference.NodeId != own]
            del space[own]

    # ---- nodes of the address space

    def _add(self, node_id: ua.NodeId, node: Node, parent: ua.NodeId, reference: int = _O.HasComponent) -> None:
        item = ua.AddNodesItem()
        item.RequestedNewNodeId, item.ParentNodeId = node_id, parent
        item.BrowseName = ua.QualifiedName(node.name, node_id.NamespaceIndex)
        item.NodeClass = _CLASSES[node.kind]
        item.ReferenceTypeId = ua.NodeId(reference)
        item.NodeAttributes = _attributes(node)
        if node.kind is Kind.VARIABLE:
            item.TypeDefinition = ua.NodeId(_O.AnalogUnitType if node.unit else _O.BaseDataVariableType)
        elif node.kind is Kind.OBJECT:
            item.TypeDefinition = ua.NodeId(_O.FolderType if not node.path else _O.BaseObjectType)
        [result] = self._server.iserver.node_mgt_service.add_nodes([item])
        if not result.StatusCode.is_good():
            log.warning("node %s: %s", node_id.to_string(), result.StatusCode.name)
            return
        self._nodes[node_id] = node
        self._add_properties(node_id, node)

    def _add_properties(self, node_id: ua.NodeId, node: Node) -> None:
        if node.unit:
            units = ua.Variant(engineering_units(node.unit), ua.VariantType.ExtensionObject)
            self._add_property(node_id, "EngineeringUnits", units, _O.EUInformation)
        if (limits := value_range(node)) is not None:
            self._add_property(node_id, "InstrumentRange", ua.Variant(limits, ua.VariantType.ExtensionObject), _O.Range)
        if node.choices:
            values = [
                ua.EnumValueType(Value=number, DisplayName=ua.LocalizedText(name)) for name, number in node.choices
            ]
            self._add_property(
                node_id,
                "EnumValues",
                ua.Variant(values, ua.VariantType.ExtensionObject, is_array=True),
                _O.EnumValueType,
            )
        for name, arguments in (("InputArguments", node.arguments), ("OutputArguments", node.results)):
            if arguments:
                descriptions = [described(argument) for argument in arguments]
                self._add_property(
                    node_id, name, ua.Variant(descriptions, ua.VariantType.ExtensionObject, is_array=True), _O.Argument
                )

    def _add_property(self, owner: ua.NodeId, name: str, value: ua.Variant, data_type: int) -> None:
        attributes = ua.VariableAttributes()
        attributes.DisplayName, attributes.Description = ua.LocalizedText(name), ua.LocalizedText("")
        attributes.DataType, attributes.Value = ua.NodeId(data_type), value
        attributes.ValueRank = 1 if value.is_array else -1
        attributes.AccessLevel = attributes.UserAccessLevel = _READ
        item = ua.AddNodesItem()
        item.RequestedNewNodeId = ua.NodeId(f"{owner.Identifier}{_PROPERTY}{name}", owner.NamespaceIndex)
        item.ParentNodeId, item.BrowseName = owner, ua.QualifiedName(name, 0)
        item.NodeClass, item.NodeAttributes = ua.NodeClass.Variable, attributes
        item.ReferenceTypeId, item.TypeDefinition = ua.NodeId(_O.HasProperty), ua.NodeId(_O.PropertyType)
        self._server.iserver.node_mgt_service.add_nodes([item])


def node_id_of(path: str, index: int) -> ua.NodeId:
    return ua.NodeId(path or ROOT, index)


_PROPERTY: Final = "#"
_SUFFIXES: Final = tuple(
    f"{_PROPERTY}{name}"
    for name in ("EngineeringUnits", "InstrumentRange", "EnumValues", "InputArguments", "OutputArguments")
)


def _is_property(node_id: ua.NodeId) -> bool:
    return _PROPERTY in str(node_id.Identifier)


def _attributes(node: Node) -> ua.NodeAttributes:
    name, about = ua.LocalizedText(node.name), ua.LocalizedText(node.about)
    if node.kind is Kind.OBJECT:
        return ua.ObjectAttributes(DisplayName=name, Description=about)
    if node.kind is Kind.METHOD:
        return ua.MethodAttributes(DisplayName=name, Description=about, Executable=True, UserExecutable=True)
    attributes = ua.VariableAttributes(DisplayName=name, Description=about)
    ua_type = mapped(node)
    attributes.DataType = ua.NodeId(ua_type.data_type)
    attributes.Value = ua.Variant(None, ua.VariantType.Null)
    attributes.ValueRank = -1 if node.length is None else 1
    attributes.ArrayDimensions = [] if node.length is None else [node.length]
    attributes.AccessLevel = attributes.UserAccessLevel = _READ | _WRITE if node.is_writable else _READ
    attributes.MinimumSamplingInterval = 0.0
    return attributes


def _change(node_id: ua.NodeId, verb: int) -> ua.ModelChangeStructureDataType:
    return ua.ModelChangeStructureDataType(Affected=node_id, AffectedType=ua.NodeId(), Verb=int(verb))
