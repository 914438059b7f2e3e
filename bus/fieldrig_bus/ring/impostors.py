"""Members that send as the master of a ring without being it, such as a test that listens without an interest."""

import logging

log = logging.getLogger(__name__)


class Impostors:
    """Drops what they send, and names each of them once in the log."""

    def __init__(self) -> None:
        self._named: set[str] = set()

    def drop(self, member: str) -> None:
        if member not in self._named:
            self._named.add(member)
            log.warning(
                "%s is not the master of the ring, and what it sends as the master is dropped; "
                'expected it to listen as the master before: on_receive(handler, ["master"])',
                member,
            )
