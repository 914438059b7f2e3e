"""Parameters: stored (1010h), restored (1011h), and the date of their configuration (1020h).

Source: CiA 301 7.5.2.10, 7.5.2.11, 7.5.2.24.  Stored are variables that the network may write, but for process
outputs, domains, and what a reader gives, since that lives elsewhere; only what differs from the factory's value is
kept, so a default COB-ID follows the node-ID.  'Load' takes effect with the reset that follows it (1011h).
"""

import logging
from collections.abc import Callable, Iterator

from fieldrig.store import StoreError
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.datatypes import DOMAIN
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.emcy import HISTORY
from fieldrig_devices.canopen.nonvolatile import NonVolatile
from fieldrig_devices.canopen.variable import Access, Variable

log = logging.getLogger(__name__)

STORE, RESTORE, VERIFY = 0x1010, 0x1011, 0x1020
SAVE, LOAD = b"save", b"load"
ON_COMMAND = b"\x01\x00\x00\x00"
"""Read from 1010h and 1011h: it is done when it is asked for."""

# By sub-index of 1010h and 1011h; from 4 on the manufacturer's.
GROUPS = {1: range(0x1000, 0x1_0000), 2: range(0x1000, 0x2000), 3: range(0x6000, 0xA000)}
MANUFACTURER = range(0x2000, 0x6000)
NOT_STORED = (STORE, RESTORE, HISTORY)


class Parameters:
    """Sets where each variable starts: as the factory has it, or as it was stored."""

    def __init__(self, dictionary: Dictionary, kept: NonVolatile) -> None:
        self._dictionary, self._kept = dictionary, kept
        self._factory = {variable: variable.start for variable in dictionary}
        self._apply()
        for index, command in ((STORE, self._command(SAVE, self._save)), (RESTORE, self._command(LOAD, self._load))):
            for entry in dictionary.members(index):
                entry.reader = lambda: ON_COMMAND
                entry.writer = command(entry)
        self._verified = dictionary.members(VERIFY)
        for variable in dictionary if self._verified else ():
            if is_stored(variable) and not variable.is_mappable and variable.index != VERIFY:
                variable.watchers.append(self._on_change)

    def refit(self, factory: Dictionary) -> None:
        """The node-ID is another: start from the values of `factory`, which has the same variables."""
        for variable in self._dictionary:
            self._factory[variable] = factory.find(variable.index, variable.subindex).start
        self._apply()

    def _apply(self) -> None:
        for variable, factory in self._factory.items():
            stored = self._kept.objects.get(variable.key)
            variable.start = factory if stored is None or not _fits(variable, stored) else stored

    def _command(self, signature: bytes, act: Callable[[range], None]) -> Callable[[Variable], Callable[[bytes], None]]:
        def writer_of(entry: Variable) -> Callable[[bytes], None]:
            group = GROUPS.get(entry.subindex, MANUFACTURER)

            def write(data: bytes) -> None:
                if data != signature:
                    raise Abort(Code.NOT_STORED)
                try:
                    act(group)
                except StoreError as cause:
                    raise Abort(Code.HARDWARE) from cause

            return write

        return writer_of

    def _stored(self, group: range) -> Iterator[Variable]:
        return (variable for variable in self._dictionary if variable.index in group and is_stored(variable))

    def _save(self, group: range) -> None:
        objects = dict(self._kept.objects)
        for variable in self._stored(group):
            objects[variable.key] = variable.data
            if variable.data == self._factory[variable]:
                del objects[variable.key]
        self._keep(objects)

    def _load(self, group: range) -> None:
        gone = {variable.key for variable in self._stored(group)}
        self._keep({key: data for key, data in self._kept.objects.items() if key not in gone})

    def _keep(self, objects: dict[str, bytes]) -> None:
        before, self._kept.objects = self._kept.objects, objects
        try:
            self._kept.save()
        except StoreError:
            self._kept.objects = before
            raise
        self._apply()

    def _on_change(self) -> None:
        """7.5.2.24: another configuration has no date yet."""
        for entry in self._verified:
            entry.set(bytes(len(entry.data)))


def is_stored(variable: Variable) -> bool:
    is_output = variable.is_mappable and variable.access in (Access.RWW, Access.WO)
    is_kept = variable.access.is_writable and variable.index not in NOT_STORED and variable.reader is None
    return is_kept and not is_output and variable.type is not DOMAIN


def _fits(variable: Variable, data: bytes) -> bool:
    """Whether a stored value is one of this variable: the EDS may be another since."""
    if not is_stored(variable) or variable.type.size not in (None, len(data)) or variable.refusal(data) is not None:
        log.warning("%s: what is stored doesn't fit the EDS; passed over", variable.key)
        return False
    return True
