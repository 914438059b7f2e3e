"""`dualport.shm`: a DualPort memory in a file of the run folder, which other processes of the host map.

The file is `dualport/NAME` with 4096 bytes.  Word n is at byte 2 n in the byte order of the host, and an access to it
is atomic, because the processor reads and writes an aligned word as a whole.  The file keeps its contents when the rig
ends, as the memory on a card does.  Nothing announces a change: each side looks as often as it wants.  Faults act at
the end of each device.
"""

import mmap
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Final

from pydantic import Field

from fieldrig.bus import Attachment, DirectBus, Time
from fieldrig.device import Tool, WayIn
from fieldrig.errors import BusError
from fieldrig.link import SharedWords
from fieldrig.settings import Settings
from fieldrig.system.own_files import open_file
from fieldrig_bus.dualport.faults import MODELS, FaultyWords, MemoryFault
from fieldrig_bus.dualport.message import WORDS, Words, check_interest, check_sent, decode, encode, show

SIZE: Final = 2 * WORDS


class SharedMemory:
    """The memory in a file, for any process that maps it."""

    def __init__(self, path: Path) -> None:
        """Make the file if there is none.  OSError if that is not possible."""
        path.parent.mkdir(parents=True, exist_ok=True)
        with open_file(path, "a+b") as file:
            file.truncate(SIZE)
            self._map = mmap.mmap(file.fileno(), SIZE)
        self._view = memoryview(self._map).cast("H")
        self.words: SharedWords = self._view

    def read(self, word: int, count: int) -> list[int]:
        return [self.words[cell] for cell in range(word, word + count)]

    def write(self, word: int, values: Sequence[int]) -> None:
        for cell, value in enumerate(values, word):
            self.words[cell] = value

    def close(self) -> None:
        self._view.release()
        self._map.close()


class MemoryEnd:
    """One device's end; it implements `MemoryLink`."""

    def __init__(self, at: Attachment, memory: SharedMemory, faults: Iterable[MemoryFault] = ()) -> None:
        self._at, self.memory = at, memory
        words = FaultyWords(at, memory.words, faults)
        self.words: SharedWords | None = words
        self.injected = words.injected
        """The faults of this end."""
        self._words = words

    def send(self, message: Words) -> None:
        for word, value in enumerate(message.values, message.first):
            self._words[word] = value
        self._at.heard(self._at.member, message)

    def on_receive(self, handler: Callable[[Words], None], interest: Sequence[object] | None = None) -> None:
        """Do nothing, as a memory reports nothing by itself."""


class DualPortSettings(Settings):
    faults: list[MemoryFault] = Field(default=[], description="faults at each device's own end, from the start")


class DualPortShm(DirectBus[Words]):
    about: ClassVar[str] = "a DualPort memory in a file, which processes of one host share"
    times: ClassVar[frozenset[Time]] = frozenset({"real"})
    family: ClassVar[str] = "dualport"
    notes_faults: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = (Words,)
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    encode = staticmethod(encode)
    decode = staticmethod(decode)
    show = staticmethod(show)
    check = staticmethod(check_sent)
    check_interest = staticmethod(check_interest)

    def __init__(self, name: str, settings: DualPortSettings) -> None:
        super().__init__(name, settings)
        self._ends: dict[str, MemoryEnd] = {}

    async def open(self, at: Attachment) -> MemoryEnd:
        path = at.path(f"dualport/{self.name}")
        try:
            memory = SharedMemory(path)
        except OSError as cause:
            raise BusError(f"{path} cannot be mapped: {cause}", "check the permissions and the space there") from cause
        end = self._ends[at.member] = MemoryEnd(at, memory, self.settings.faults)
        return end

    async def close(self, member: str) -> None:
        self._ends.pop(member).memory.close()

    def ways_in(self, run: Path) -> list[WayIn]:
        return [WayIn("shared memory", str(run / "dualport" / self.name))]

    def tools(self, run: Path) -> list[Tool]:
        return [Tool("memory", f"od -A d -t x2 {run}/dualport/{self.name}")]
