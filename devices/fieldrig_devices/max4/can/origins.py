"""The origins of homed axes, stored on the flash disk because the encoders are absolute (digest PD-174)."""

import json
import logging

from fieldrig.outside.untrusted import read_json, typed
from fieldrig.storage import store_format
from fieldrig.storage.store import Store, StoreError, restore

log = logging.getLogger(__name__)


class Origins:
    """Zeros of user positions in increments, by the names of the axes; a store that cannot be read has none."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._origins = restore(store, _decode).content or {}

    def of(self, name: str) -> float | None:
        """The origin of an axis, or None if it was never homed."""
        return self._origins.get(name)

    def put(self, name: str, origin: float) -> None:
        """Store the origin of an axis; if that fails, it is valid until power-off, and the next save includes it."""
        self._origins[name] = origin
        try:
            self._store.save(json.dumps(self._origins).encode())
        except StoreError as cause:
            log.debug("the origin of %s is valid only until power-off: %s", name, cause.strerror)


def _decode(data: bytes) -> dict[str, float]:
    """The stored origins.  ValueError for data that `put` cannot have written."""
    origins = typed(read_json(data, store_format.LONGEST), dict)
    return {name: typed(origin, float, name) for name, origin in origins.items()}
