"""What the node's store holds: parameters that were stored, and what LSS has configured.

One JSON text, so that a person can read it.  What it can't make out, of another version or broken, it passes over:
the node then starts as it left the factory.
"""

import json
import logging
from typing import Any

from fieldrig.store import Store

log = logging.getLogger(__name__)

VERSION = 1


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
        data = store.load()
        if data is not None:
            self._read(data)

    def save(self) -> None:
        """OSError if it can't be kept."""
        content = {
            "version": VERSION,
            "lss": {"node_id": self.node_id, "in_place_of": self._setting, "bit_timing": self.bit_timing},
            "objects": {key: data.hex() for key, data in sorted(self.objects.items())},
        }
        self._store.save(json.dumps(content).encode())

    def _read(self, data: bytes) -> None:
        try:
            content = json.loads(data)
            if content["version"] != VERSION:
                raise ValueError(f"of version {content['version']}")
            objects = {str(key): bytes.fromhex(value) for key, value in content["objects"].items()}
            lss = content["lss"]
            node_id = _number(lss["node_id"]) if lss["in_place_of"] == self._setting else None
            bit_timing = _number(lss["bit_timing"])
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as wrong:
            log.warning("what is stored can't be used (%s): starting with what the EDS says", wrong)
            return
        self.objects, self.node_id, self.bit_timing = objects, node_id, bit_timing


def _number(value: Any) -> int | None:
    if value is None or (isinstance(value, int) and 0 <= value <= 255):
        return value
    raise ValueError(f"{value!r} is no number from 0 to 255")
