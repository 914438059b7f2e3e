"""The slaves of the masters of a rig: what these write into them at their start, and the PDOs of slaves outside.

Source: CiA 301 version 4.2, 7.3.5 (predefined connection set) for the identifiers of a slave without an EDS.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final, NamedTuple

from fieldrig.traces.names import Member
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds.reader import load
from fieldrig_devices.canopen.master_settings import CanMasterSettings, CanNodeSettings
from fieldrig_devices.canopen.names import KnownNode
from fieldrig_devices.export.network import Message, Signal, with_unique_names
from fieldrig_devices.registers.packed import Element

FIRST_TPDO, FIRST_RPDO, NEXT_PDO = 0x180, 0x200, 0x100
SIGNED: Final = ("s8", "s16", "s32")


class Managed(NamedTuple):
    """A slave by the name that its master has for it."""

    name: str
    settings: CanNodeSettings

    @property
    def known(self) -> KnownNode:
        """The slave as a node, for one that is no device of the rig."""
        eds = self.settings.eds
        return KnownNode(self.name, None if eds is None else load(eds, self.settings.node_id))


def managed(members: Iterable[Member]) -> Iterator[Managed]:
    """Yield the slaves of all masters at a bus."""
    for member in members:
        master = getattr(member.entry.settings, "can_master", None)
        if isinstance(master, CanMasterSettings) and member.claims("master of node-ID"):
            yield from (Managed(name, settings) for name, settings in master.nodes.items())


def configure(dictionary: Dictionary, settings: CanNodeSettings) -> None:
    """Write into a dictionary what the master writes before the slave starts, as far as the slave takes it."""
    for write in settings.configuration():
        variable = dictionary.get(write.index, write.subindex)
        if variable is not None and variable.type.size in (None, len(write.data)):
            variable.set(write.data)


def declared_pdos(node: str, settings: CanNodeSettings, master: str) -> Iterator[Message]:
    """Yield the PDOs that the master expects of a slave and sends to it, with the names of its values."""
    for word, first, pdos, sender, receiver in (
        ("TPDO", FIRST_TPDO, settings.inputs, node, master),
        ("RPDO", FIRST_RPDO, settings.outputs, master, node),
    ):
        for number, elements in pdos.items():
            identifier = first + (number - 1) * NEXT_PDO + settings.node_id
            signals = tuple(with_unique_names(_signals(elements)))
            length = (sum(signal.length for signal in signals) + 7) // 8
            name, about = f"{node}_{word}{number}", f"{word} {number} of {node}"
            yield Message(identifier, name, length, signals, sender, (receiver,), about)


def _signals(elements: Sequence[Element]) -> Iterator[Signal]:
    at = 0
    for element in elements:
        is_signed, is_float = element.type in SIGNED, element.type == "f32"
        yield Signal(element.name, at, element.form.bits, is_signed=is_signed, is_float=is_float)
        at += element.form.bits
