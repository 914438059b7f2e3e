"""Where axes were homed, kept on the flash disk, as their encoders are absolute (digest PD-174)."""

import json
import logging
from typing import Any

from fieldrig.store import Store

log = logging.getLogger(__name__)


class Origins:
    """Zeros of the users' positions in increments, by the names of the axes.  What can't be read is none."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._origins: dict[str, float] = {}
        try:
            found: Any = json.loads(store.load() or b"{}")
            self._origins = {str(name): float(origin) for name, origin in found.items()}
        except (ValueError, TypeError, AttributeError, RecursionError) as wrong:
            log.warning("origins of axes are lost: %s", wrong)

    def of(self, name: str) -> float | None:
        return self._origins.get(name)

    def put(self, name: str, origin: float) -> None:
        self._origins[name] = origin
        try:
            self._store.save(json.dumps(self._origins).encode())
        except OSError as wrong:
            log.warning("the origin of %s holds until power-off: %s", name, wrong)
