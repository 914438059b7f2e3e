"""The faults of a DualPort memory, at a device's own end: what the device reads and writes is wrong.

Other programs that map the memory have no end in the rig: they see what reaches the file.
"""

from collections.abc import Callable, Iterable
from typing import Annotated, Any, Final, Literal, Protocol

from pydantic import Field

from fieldrig.bus import Attachment
from fieldrig.clock import MS
from fieldrig.faults.faults import LONGEST_MS, Fault, Faults, Timed, models_of
from fieldrig.faults.injected import InjectedFaults
from fieldrig.faults.note import FaultNote
from fieldrig.link import SharedWords
from fieldrig_bus.dualport.message import WORDS

Word = Annotated[int, Field(ge=0, lt=WORDS)]


class Stuck(Timed):
    """One word does not change, regardless of the writer."""

    what: Literal["stuck"]
    word: Word = Field(description="number of the word")
    value: int | None = Field(default=None, ge=0, le=0xFFFF, description="the value; left out: that of the begin")


class Torn(Timed):
    """A block that the device writes is seen half old and half new: the second half of its words comes later."""

    what: Literal["torn"]
    word: Word = Field(description="number of the first word of the block")
    count: int = Field(default=2, ge=2, le=WORDS, description="words of the block")
    late_ms: float = Field(default=20.0, gt=0, le=LONGEST_MS, description="time between the halves")

    def is_late(self, word: int) -> bool:
        """True for a word of the second half."""
        return self.word + self.count // 2 <= word < self.word + self.count


class Dead(Timed):
    """The other side is dead: what it writes does not arrive.  The device reads the words that it writes itself."""

    what: Literal["dead"]


MemoryFault = Annotated[Stuck | Torn | Dead, Field(discriminator="what")]
MODELS: Final = models_of(MemoryFault)


class _State(Protocol):
    """The effect of a fault that is on."""

    def read(self, word: int) -> int | None:
        """Return the value that is read instead; None for the right one."""

    def write(self, word: int, value: int) -> bool:
        """Return whether the value is kept from the memory."""


class _Stuck:
    def __init__(self, settings: Stuck, words: SharedWords) -> None:
        self._word = settings.word
        self._value = words[settings.word] if settings.value is None else settings.value
        words[settings.word] = self._value

    def read(self, word: int) -> int | None:
        return self._value if word == self._word else None

    def write(self, word: int, value: int) -> bool:
        return word == self._word


class _Torn:
    def __init__(self, settings: Torn, write_late: Callable[[int, int, int], None]) -> None:
        self._settings, self._write_late = settings, write_late

    def read(self, word: int) -> int | None:
        return None

    def write(self, word: int, value: int) -> bool:
        if not self._settings.is_late(word):
            return False
        self._write_late(word, value, round(self._settings.late_ms * MS))
        return True


class _Dead:
    def __init__(self, words: SharedWords) -> None:
        self._known = [words[word] for word in range(WORDS)]

    def read(self, word: int) -> int | None:
        return self._known[word]

    def write(self, word: int, value: int) -> bool:
        self._known[word] = value
        return False


class FaultyWords:
    """The words of a memory as one device reads and writes them."""

    def __init__(self, at: Attachment, words: SharedWords, faults: Iterable[MemoryFault]) -> None:
        self._at, self._words = at, words
        self._states: dict[int, _State] = {}
        """The faults that are on, by number."""
        self._late: dict[int, tuple[int, int]] = {}
        """The words that are still to be written, by number: the instant, and the value."""
        self.injected: InjectedFaults[Fault[Any]] = InjectedFaults(
            at.clock, MODELS, Faults(Fault), on_change=self._on_change
        )
        for fault in faults:
            self.injected.add(fault)

    def __getitem__(self, word: int, /) -> int:
        stuck = self._stuck_at(word)
        if stuck is not None:
            return stuck
        for state in self._states.values():
            read = state.read(word)
            if read is not None:
                return read
        return self._words[word]

    def __setitem__(self, word: int, value: int, /) -> None:
        self._late.pop(word, None)
        kept = [state.write(word, value) for state in self._states.values()]  # each hears of it
        if not any(kept):
            self._words[word] = value

    def _write_late(self, word: int, value: int, late_ns: int) -> None:
        """Write a word later, unless it is written again or sticks before."""
        due_ns = max(self._at.clock.now_ns() + late_ns, self._late.get(word, (0, 0))[0])
        self._late[word] = due_ns, value

        def arrive() -> None:
            if self._late.get(word) == (due_ns, value):
                del self._late[word]
                if self._stuck_at(word) is None:
                    self._words[word] = value

        self._at.clock.call_at(due_ns, arrive)

    def _stuck_at(self, word: int) -> int | None:
        """Return the value at which a word sticks; None for a sound one."""
        stuck = (state.read(word) for state in self._states.values() if isinstance(state, _Stuck))
        return next((value for value in stuck if value is not None), None)

    def _on_change(self) -> None:
        now_ns = self._at.clock.now_ns()
        present = {fault.number: fault.settings for fault in self.injected.records if fault.is_on(now_ns)}
        for number in self._states.keys() - present.keys():
            del self._states[number]
        for number, settings in present.items():
            if number not in self._states:
                self._states[number] = self._state(settings)
                self._at.heard(self._at.member, FaultNote(number, settings.what))

    def _state(self, settings: Any) -> _State:
        match settings:
            case Stuck():
                return _Stuck(settings, self._words)
            case Torn():
                return _Torn(settings, self._write_late)
        return _Dead(self._words)
