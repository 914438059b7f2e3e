"""Non-volatile memory of the node: stored parameters, and the configuration by LSS.

It is one JSON text, so that people can read it.  Content that the node cannot have stored counts as damage; without a
usable version, the node starts with the values of the EDS.
"""

import json
from typing import Any, NamedTuple

from fieldrig.outside.untrusted import field, read_json, typed
from fieldrig.storage import store_format
from fieldrig.storage.store import Store, restore
from fieldrig_devices.canopen.bit_timing import BIT_RATES

VERSION = 1
NODE_IDS = frozenset((*range(1, 128), 255))
"""Node-IDs that LSS may configure; 255 is none."""


class _Content(NamedTuple):
    objects: dict[str, bytes]
    node_id: int | None
    in_place_of: int | None
    bit_timing: int | None


class NonVolatile:
    """The stored values.  Change the attributes, then call `save`.

    `node_id_setting` is the node-ID of the rig file: once it changes there, a stored node-ID is no longer valid.
    """

    def __init__(self, store: Store, node_id_setting: int | None) -> None:
        self._store, self._setting = store, node_id_setting
        self.objects: dict[str, bytes] = {}
        """Stored values by key, such as 1017:00."""
        self.node_id: int | None = None
        self.bit_timing: int | None = None
        """Index of the bit timing table; None if LSS has stored none."""
        content = restore(store, _decode).content
        if content is not None:
            self.objects, self.bit_timing = content.objects, content.bit_timing
            self.node_id = content.node_id if content.in_place_of == node_id_setting else None

    def save(self) -> None:
        """Write the values to the store.  Raises StoreError if it fails."""
        content = {
            "version": VERSION,
            "lss": {"node_id": self.node_id, "in_place_of": self._setting, "bit_timing": self.bit_timing},
            "objects": {key: data.hex() for key, data in sorted(self.objects.items())},
        }
        self._store.save(json.dumps(content).encode())


def _decode(data: bytes) -> _Content:
    """Decode stored content.  Raises ValueError for content that `save` cannot have written."""
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
        raise ValueError(f"{key} cannot be {value}")
    return int(value)
