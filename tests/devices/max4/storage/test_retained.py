"""Retain data in buffered RAM: a kill at any instant leaves the values of one cycle."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.max4.storage.retained import MARK_BYTES, Retained, Values, extra_bytes

SIZE = 64
OLD = Values(b"program1", bytes(range(40)))
NEW = Values(b"program2", bytes(range(100, 164)))


class Killed(Exception):  # noqa: N818
    """The process has been killed."""


class DyingMemory:
    """Memory whose writer is killed after a number of bytes; aligned words are never torn."""

    def __init__(self, size: int, budget: list[int]) -> None:
        self.data = bytearray(size)
        self._budget = budget

    def __len__(self) -> int:
        return len(self.data)

    def __getitem__(self, part: slice) -> bytes:
        return bytes(self.data[part])

    def __setitem__(self, part: slice, new: bytes) -> None:
        first, last, _ = part.indices(len(self.data))
        assert last - first == len(new)
        for at, value in zip(range(first, last), new, strict=True):
            if self._budget[0] <= 0:
                raise Killed
            self._budget[0] -= 1
            self.data[at] = value

    def write_word(self, at: int, value: int) -> None:
        if self._budget[0] <= 0:
            raise Killed
        self._budget[0] -= 1
        self.data[at : at + 4] = value.to_bytes(4, "little")


def restarted(memory: bytes, beside: bytes) -> Retained:
    found = Retained(memoryview(bytearray(memory)), memoryview(bytearray(beside)))
    found.recover()
    return found


def test_values_are_read_back_after_a_commit() -> None:
    assert restarted(bytes(SIZE), bytes(extra_bytes(SIZE))).values is None
    retained = restarted(bytes(SIZE), bytes(extra_bytes(SIZE)))
    retained.commit(OLD)
    assert retained.values == OLD
    retained.commit(NEW)
    assert retained.values == NEW
    retained.clear()
    assert retained.values is None


@pytest.mark.manual("PD-048", "PD-315")
def test_a_kill_at_any_byte_of_a_commit_leaves_the_old_or_the_new_values(monkeypatch: pytest.MonkeyPatch) -> None:
    class Word:
        """An aligned word, which is written as a whole."""

        @staticmethod
        def unpack_from(memory: DyingMemory, at: int) -> tuple[int]:
            return (int.from_bytes(memory[at : at + 4], "little"),)

        @staticmethod
        def pack_into(memory: DyingMemory, at: int, value: int) -> None:
            memory.write_word(at, value)

    found = set()
    writes = 1 + 2 * (len(NEW.data) + 16) + 1
    for budget in range(writes + 1):
        left = [1 << 30]
        memory, beside = DyingMemory(SIZE, left), DyingMemory(extra_bytes(SIZE), left)
        with monkeypatch.context() as words:
            words.setattr("fieldrig_devices.max4.storage.retained._WORD", Word)
            retained = Retained(memory, beside)  # type: ignore[arg-type]  # as far as it is used
            retained.commit(OLD)
            left[0] = budget
            with suppress(Killed):
                retained.commit(NEW)
            assert left[0] == 0
        found.add(restarted(bytes(memory.data), bytes(beside.data)).values)
    assert found == {OLD, NEW}


@given(memory=st.binary(min_size=SIZE, max_size=SIZE), beside=st.data())
def test_any_content_is_survived(memory: bytes, beside: st.DataObject) -> None:
    size = extra_bytes(SIZE)
    retained = restarted(memory, beside.draw(st.binary(min_size=size, max_size=size)))
    values = retained.values
    assert values is None or len(values.mark) == MARK_BYTES
    retained.commit(OLD)
    assert retained.values == OLD


def test_a_changed_byte_makes_the_values_void() -> None:
    retained = restarted(bytes(SIZE), bytes(extra_bytes(SIZE)))
    retained.commit(OLD)
    copy = bytearray(retained.copy())
    copy[3] ^= 1
    assert retained.paste(bytes(copy))
    assert retained.values is None
    assert not retained.paste(b"123")
