"""Where axes were homed, kept on the flash disk, as their encoders are absolute (digest PD-174)."""

import json
import logging

from fieldrig import store_format
from fieldrig.store import Store, StoreError, restore
from fieldrig.untrusted import read_json, typed

log = logging.getLogger(__name__)


class Origins:
    """Zeros of the users' positions in increments, by the names of the axes.  What can't be read is none."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._origins = restore(store, _decode).content or {}

    def of(self, name: str) -> float | None:
        return self._origins.get(name)

    def put(self, name: str, origin: float) -> None:
        """If it can't be stored it holds until power-off, and the next one that can includes it."""
        self._origins[name] = origin
        try:
            self._store.save(json.dumps(self._origins).encode())
        except StoreError as cause:
            log.debug("the origin of %s holds until power-off: %s", name, cause.strerror)


def _decode(data: bytes) -> dict[str, float]:
    """ValueError for what `put` doesn't write."""
    found = typed(read_json(data, store_format.LONGEST), dict)
    return {name: typed(origin, float, name) for name, origin in found.items()}
