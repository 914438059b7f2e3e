"""PDOs by name: which PDO of which node a frame is, and the values of the objects that are mapped into it."""

from collections.abc import Iterator, Mapping
from typing import Any, Final

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.pdo_maps import PARAMETERS, Accessed, Layout, Pdo, PdoMaps
from fieldrig_devices.canopen.sdo_names import number_words, object_words, typed_words
from fieldrig_devices.canopen.variable import Variable

MOST_TEXTS: Final = 1_024
LAST_TYPE: Final = 0x0FFF
"""The highest index of a data type (CiA 301, table 38)."""


class PdoNames:
    """Names the PDOs of a bus."""

    def __init__(self, dictionaries: Mapping[int, Dictionary], known: Mapping[int, Dictionary] | None = None) -> None:
        """`dictionaries` have the parameters of the nodes, and `known` the names of their objects if it has more."""
        self._dictionaries = dictionaries
        self._known = dictionaries if known is None else known
        self._maps = PdoMaps(dictionaries)
        self._texts: dict[tuple[int, bytes], str] = {}
        """Contents that were named before, as most PDOs repeat theirs, by identifier and data."""
        self._fields: dict[Pdo, list[_Field]] = {}

    def note(self, node_id: int, index: int, subindex: int, number: int) -> None:
        """Take into account that a parameter of a node has this number now."""
        if self._maps.put(node_id, index, subindex, number):
            self.forget_texts()

    def take(self, transfer: Accessed) -> None:
        """Learn from a completed SDO transfer."""
        if self._maps.take(transfer):
            self.forget_texts()

    def forget_texts(self) -> None:
        """Name the contents again, because objects have other names or places now."""
        self._texts.clear()
        self._fields.clear()

    def parameters(self) -> dict[int, list[str]]:
        """Return the keys of all parameters of PDOs, by node-ID."""
        return {
            node_id: [variable.key for variable in dictionary if variable.index in PARAMETERS]
            for node_id, dictionary in self._dictionaries.items()
        }

    def learn(self, node_id: int, values: Mapping[str, Any]) -> None:
        """Take the present numbers of parameters, by key."""
        for key, number in values.items():
            index, subindex = (int(part, 16) for part in key.split(":"))
            if isinstance(number, int) and not self._maps.knows(node_id, index, subindex):
                self.note(node_id, index, subindex, number)

    def named(self, frame: CanFrame) -> tuple[int, str, str] | None:
        """Return node-ID, name and content of a PDO; None for any other frame."""
        if frame.is_remote:
            pdo = self._maps.pdo_of(_key(frame))
            return None if pdo is None else (pdo.node_id, f"{pdo.kind} request", "")
        return self.of_data(_key(frame), frame.data)

    def of_data(self, key: int, data: bytes) -> tuple[int, str, str] | None:
        """Return the same for a data frame, by its identifier, where bit 31 marks one of 29 bits."""
        pdo = self._maps.pdo_of(key)
        if pdo is None:
            return None
        text = self._texts.get((key, data))
        if text is None:
            if len(self._texts) >= MOST_TEXTS:
                self._texts.clear()
            text = self._texts[key, data] = self._content(pdo, data)
        return pdo.node_id, pdo.kind, text

    def values(self, frame: CanFrame) -> tuple[int, str, list[tuple[int, int, bytes]]] | None:
        """Return node-ID, name, and the mapped objects with their data; None for a frame that is no PDO."""
        pdo = self._maps.pdo_of(_key(frame))
        if pdo is None or frame.is_remote:
            return None
        return pdo.node_id, pdo.kind, list(_objects(self._maps.layout(pdo), frame.data))

    def producer_of(self, frame: CanFrame) -> int | None:
        """Return the node-ID of the node that sends this TPDO; None for any other frame."""
        pdo = self._maps.pdo_of(_key(frame))
        return pdo.node_id if pdo is not None and pdo.kind.startswith("TPDO") else None

    def node_of(self, frame: CanFrame) -> int | None:
        """Return the node-ID of the node whose PDO this is; None for any other frame."""
        pdo = self._maps.pdo_of(_key(frame))
        return None if pdo is None else pdo.node_id

    def _content(self, pdo: Pdo, data: bytes) -> str:
        bits, length, words = int.from_bytes(data, "little"), 8 * len(data), []
        for field in self._fields_of(pdo):
            if field.end > length:
                words.append("too short for its mapping")
                break
            if field.label:
                number = bits >> field.begin & field.mask
                if field.words is not None:
                    words.append(field.label + field.words(number))
                else:
                    words.append(field.label + typed_words(field.variable, number.to_bytes(field.size, "little")))
        return ", ".join(words) or data.hex(" ").upper()

    def _fields_of(self, pdo: Pdo) -> "list[_Field]":
        found = self._fields.get(pdo)
        if found is None:
            found, begin = [], 0
            for node_id, index, subindex, length in self._maps.layout(pdo) or ():
                dictionary = self._known.get(node_id)
                variable = None if dictionary is None else dictionary.get(index, subindex)
                found.append(_Field(begin, begin + length, variable, _label(variable, index, subindex)))
                begin += length
            self._fields[pdo] = found
        return found


class _Field:
    """One object in a PDO."""

    __slots__ = ("begin", "end", "label", "mask", "size", "variable", "words")

    def __init__(self, begin: int, end: int, variable: Variable | None, label: str) -> None:
        """`begin` and `end` are in bits."""
        self.begin, self.end, self.variable, self.label = begin, end, variable, label
        self.mask, self.size = (1 << end - begin) - 1, (end - begin + 7) // 8
        self.words = number_words(variable, end - begin)


def _label(variable: Variable | None, index: int, subindex: int) -> str:
    """Return what is written before a value; nothing for a dummy, which nothing means."""
    if variable is not None:
        return f"{variable.name} "
    return "" if index <= LAST_TYPE else f"{object_words(None, index, subindex)} = "


def _key(frame: CanFrame) -> int:
    return frame.identifier | EXTENDED_KEY if frame.is_extended else frame.identifier


def _objects(layout: Layout | None, data: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Yield index, sub-index and data of each object, as far as the data go."""
    bits, at = int.from_bytes(data, "little"), 0
    for _, index, subindex, length in layout or ():
        if at + length > 8 * len(data):
            return
        yield index, subindex, (bits >> at & (1 << length) - 1).to_bytes((length + 7) // 8, "little")
        at += length
