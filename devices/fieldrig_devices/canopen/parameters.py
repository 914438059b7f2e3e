"""Parameters: storing (1010h), restoring (1011h), and the date of their configuration (1020h).

Source: CiA 301 7.5.2.10, 7.5.2.11, 7.5.2.24.  All variables that the network may write are stored, except process
outputs, domains, and variables with a reader, whose value has its place elsewhere.  Only values that differ from the
default are kept, so that a default COB-ID follows the node-ID.  'Load' takes effect with the next reset (1011h).
"""

import logging
from collections.abc import Callable, Iterator

from fieldrig.storage.store import StoreError
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.datatypes import DOMAIN
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.emcy import HISTORY
from fieldrig_devices.canopen.nonvolatile import NonVolatile
from fieldrig_devices.canopen.variable import Variable

log = logging.getLogger(__name__)

STORE, RESTORE, VERIFY = 0x1010, 0x1011, 0x1020
SAVE, LOAD = b"save", b"load"
ON_COMMAND = b"\x01\x00\x00\x00"
"""Value of 1010h and 1011h: the device stores and restores on command."""

# Objects by sub-index of 1010h and 1011h; those from 4 on are manufacturer-specific.
GROUPS = {1: range(0x1000, 0x1_0000), 2: range(0x1000, 0x2000), 3: range(0x6000, 0xA000)}
MANUFACTURER = range(0x2000, 0x6000)
NOT_STORED = (STORE, RESTORE, HISTORY)


class Parameters:
    """Sets the power-on value of each variable: the default of the EDS, or the stored value."""

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
        """Take the defaults from `factory`, which has the same variables, after a change of the node-ID."""
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
        """Set the configuration date to 0: any change invalidates it (7.5.2.24)."""
        for entry in self._verified:
            entry.set(bytes(len(entry.data)))


def is_stored(variable: Variable) -> bool:
    is_kept = variable.access.is_writable and variable.index not in NOT_STORED and variable.reader is None
    return is_kept and not variable.is_process_output and variable.type is not DOMAIN


def _fits(variable: Variable, data: bytes) -> bool:
    """True if a stored value fits this variable; the EDS may have changed since it was stored."""
    if not is_stored(variable) or variable.type.size not in (None, len(data)) or variable.refusal(data) is not None:
        log.warning("%s: the stored value doesn't fit the EDS and is ignored", variable.key)
        return False
    return True
