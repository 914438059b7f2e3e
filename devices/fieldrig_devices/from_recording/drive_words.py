"""The control word, the status word and the mode of a drive during a recording, by SDO and by PDO, in their order."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from fieldrig_devices.cia402.objects import CONTROL_WORD, MODE
from fieldrig_devices.dialogues import SdoTransfer
from fieldrig_devices.from_recording.node_model import PdoModel
from fieldrig_devices.from_recording.objects import WORDS


class Word(NamedTuple):
    """A value of one of the words, which it had at the first instant or later, and at the second one or earlier."""

    begin_ns: int
    end_ns: int
    object: int
    value: int
    is_exact: bool = False
    """True if it was sent because it changed, so that the node had another value until then."""


def of_transfers(transfers: Iterable[SdoTransfer]) -> Iterator[Word]:
    """Yield the words that SDO transfers have carried."""
    for transfer in transfers:
        if transfer.data is not None and transfer.end_ns is not None:
            end_ns = transfer.begin_ns if transfer.is_download else transfer.end_ns
            yield Word(transfer.begin_ns, end_ns, transfer.index, int.from_bytes(transfer.data, "little"))


def words_of(transfers: Iterable[SdoTransfer], pdos: Iterable[PdoModel]) -> list[Word]:
    """Return all words of a drive; those of a PDO are its changes.

    A word of the master at the instant of one of the drive is the master's answer to it: a master in virtual time
    takes no time, and the drive cannot have seen that word before its frame was over.
    """
    found = list(of_transfers(transfers))
    for pdo in pdos:
        is_exact = pdo.rhythm is not None and not pdo.rhythm.is_synchronous and not pdo.rhythm.is_cyclic
        for place, part in enumerate(pdo.layout.parts):
            if part.object in WORDS and not part.subindex:
                found += [
                    Word(change.seen_ns, change.seen_ns, part.object, pdo.layout.values(change.value)[place], is_exact)
                    for change in pdo.log.changes.changes(0)
                ]
    return sorted(found, key=lambda word: (word.end_ns, word.object in {CONTROL_WORD, MODE}))
