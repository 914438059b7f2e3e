"""What the node's store holds: parameters that were stored, and what LSS has configured.

One JSON text, so that a person can read it.  Content that the node can't have stored counts as damage; without a usable
version the node starts with what the EDS says.
"""

import json
from typing import Any, NamedTuple

from fieldrig import store_format
from fieldrig.store import Store, restore
from fieldrig.untrusted import field, read_json, typed
from fieldrig_devices.canopen.bit_timing import BIT_RATES

VERSION = 1
NODE_IDS = frozenset((*range(1, 128), 255))
"""The ones that LSS may configure; 255: none."""


class _Content(NamedTuple):
    objects: dict[str, bytes]
    node_id: int | None
    in_place_of: int | None
    bit_timing: int | None


class NonVolatile:
    """Change the attributes, then `save`.

    `node_id_setting` is the node-ID of the configuration: a stored one holds only as long as that is not changed.
    """

    def __init__(self, store: Store, node_id_setting: int | None) -> None:
        self._store, self._setting = store, node_id_setting
        self.objects: dict[str, bytes] = {}
        """Stored values by key, such as 1017:00."""
        self.node_id: int | None = None
        self.bit_timing: int | None = None
        """Index of the bit timing table."""
        content = restore(store, _decode).content
        if content is not None:
            self.objects, self.bit_timing = content.objects, content.bit_timing
            self.node_id = content.node_id if content.in_place_of == node_id_setting else None

    def save(self) -> None:
        """StoreError if it can't be kept."""
        content = {
            "version": VERSION,
            "lss": {"node_id": self.node_id, "in_place_of": self._setting, "bit_timing": self.bit_timing},
            "objects": {key: data.hex() for key, data in sorted(self.objects.items())},
        }
        self._store.save(json.dumps(content).encode())


def _decode(data: bytes) -> _Content:
    """ValueError for what `save` doesn't write."""
    content = read_json(data, store_format.LONGEST)
    if (version := field(content, "version", int)) != VERSION:
        raise ValueError(f"it has version {version}, expected {VERSION}")
    lss = field(content, "lss", dict)
    return _Content(
        {key: bytes.fromhex(typed(value, str, key)) for key, value in field(content, "objects", dict).items()},
        _one_of(NODE_IDS, lss, "node_id"),
        _one_of(NODE_IDS, lss, "in_place_of"),
        _one_of(frozenset(BIT_RATES), lss, "bit_timing"),
    )


def _one_of(allowed: frozenset[int], lss: dict[str, Any], key: str) -> int | None:
    if key not in lss:
        raise ValueError(f"expected the key {key}")
    value = lss[key]
    if value is None:
        return None
    if typed(value, int, key) not in allowed:
        raise ValueError(f"{key} can't be {value}")
    return int(value)
