"""A card that is killed while it saves parameters has all old or all new ones, including its node's."""

from collections.abc import Iterator
from errno import ENOSPC

import pytest
from arp_bench import CardBench
from canopen_bench import parse, show
from cut_store import CutStore, Killed

from fieldrig.storage.store import StoreError
from fieldrig_bus.can.frame import CanFrame

WRITES = (
    "23 01 23 0B C4 09 00 00",  # @Par1[11] = 2.500
    "23 02 23 0B C4 09 00 00",  # @Par2[11]
    "23 02 23 08 88 13 00 00",  # @Par2[8] = 5.000
    "2F 00 18 02 01 00 00 00",  # 1800:02, TPDO 1 with each SYNC
)
OLD, NEW = (1000, 1000, 100_000_000, "ff"), (2500, 2500, 5000, "01")
"""Values of these parameters in flash, and of 1800:02."""
COMMAND_4, SAVE_ALL, SAVE_OURS = "2F 00 21 00 04 00 00 00", "23 10 10 01 73 61 76 65", "23 10 10 04 73 61 76 65"
LOAD_ALL = "23 11 10 01 6C 6F 61 64"


class FailingStore(CutStore):
    """A store that can no longer be written."""

    def save(self, data: bytes) -> None:
        try:
            super().save(data)
        except Killed as cause:
            raise StoreError(ENOSPC, "No space left on device") from cause


class Card:
    def __init__(self, store: CutStore) -> None:
        self.store = store
        self.bench = CardBench(store=store, with_can=True).run_for(50)

    def sdo(self, request: str) -> str:
        self.bench.can.take()
        self.bench.can.deliver(parse(f"60A#{request}"))
        self.bench.run_for(20)
        frames = [show(frame) for frame in self.bench.can.take() if isinstance(frame, CanFrame)]
        (answer,) = (frame[4:] for frame in frames if frame.startswith("58A#"))
        return answer

    @property
    def kept(self) -> tuple[int, int, int, str]:
        flash = self.bench.access.parameters.flash
        return flash[1][11], flash[2][11], flash[2][8], self.sdo("40 00 18 02 00 00 00 00")[12:14]


def after(data: bytes | None) -> tuple[int, int, int, str]:
    """Values that the next start finds."""
    return Card(CutStore(data)).kept


def cuts(request: str, data: bytes | None, writes: tuple[str, ...] = ()) -> Iterator[CutStore]:
    """The store after a kill at each of the writes of a request, and finally without a kill."""
    for allowed in range(100):
        card = Card(CutStore(data))
        for write in writes:
            assert card.sdo(write)[:2] == "60"
        card.store.allowed, card.store.saves = allowed, 0
        try:
            assert card.sdo(request)[:2] == "60"
        except Killed:
            yield card.store
        else:
            yield card.store
            return


@pytest.mark.long
@pytest.mark.parametrize(
    ("request_", "new"), [(COMMAND_4, (*NEW[:3], OLD[3])), (SAVE_ALL, NEW), (SAVE_OURS, (*NEW[:3], OLD[3]))]
)
def test_saving_that_is_cut_leaves_all_old_or_all_new(request_: str, new: tuple[int, int, int, str]) -> None:
    found = [after(store.load()) for store in cuts(request_, None, WRITES)]
    assert set(found[:-1]) == {OLD}
    assert found[-1] == new


@pytest.mark.long
def test_loading_that_is_cut_leaves_all_old_or_all_new() -> None:
    *_, saved = cuts(SAVE_ALL, None, WRITES)
    assert after(saved.load()) == NEW
    found = [after(store.load()) for store in cuts(LOAD_ALL, saved.load())]
    assert set(found[:-1]) == {NEW}
    assert found[-1] == OLD


def test_where_nothing_differs_nothing_is_written() -> None:
    (store,) = cuts(COMMAND_4, None)
    assert store.saves == 0


@pytest.mark.parametrize("request_", [COMMAND_4, SAVE_ALL, SAVE_OURS])
def test_what_the_memory_refuses_is_not_half_there(request_: str) -> None:
    card = Card(FailingStore())
    for write in WRITES:
        card.sdo(write)
    card.store.allowed, card.store.saves = 0, 0
    assert card.sdo(request_) == f"80 {request_[3:11]} 00 00 06 06"
    flash = card.bench.access.parameters.flash
    assert (flash[1][11], flash[2][11], flash[2][8]) == OLD[:3]
