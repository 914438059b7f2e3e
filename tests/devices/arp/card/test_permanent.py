"""V1 to V1000 are in buffered RAM at the end of each control loop, regardless of what wrote them."""

from random import Random

import pytest
from arp_bench import CardBench

from fieldrig.storage.store import MemoryStore, Store
from fieldrig.testing import RecordedLink
from fieldrig_bus.wires import Signal
from fieldrig_devices.arp.card.permanent import COUNT, MARK, Permanent, Ram


def words(store: Store) -> list[int]:
    return store.buffered_ram(4 * (COUNT + 1)).cast("i").tolist()


def test_a_blank_ram_differs_from_one_that_was_used() -> None:
    store = MemoryStore()
    assert Permanent(store).load() is Ram.BLANK
    assert Permanent(store).load() is Ram.GOOD
    store.buffered_ram(4).cast("i")[0] = 1
    assert Permanent(store).load() is Ram.DAMAGED
    assert words(store) == [MARK, *[0] * COUNT]


@pytest.mark.parametrize("at_once", [1, 5, 60, 400])
def test_whatever_changes_is_kept(at_once: int) -> None:
    random, store = Random(at_once), MemoryStore()
    permanent = Permanent(store)
    permanent.load()
    for _ in range(200):
        for _ in range(random.randint(0, at_once)):
            permanent.V[random.randint(1, COUNT)] = random.choice([0, 1, -1, random.randint(-(2**31), 2**31 - 1)])
        permanent.keep()
        assert words(store)[1:] == permanent.V[1:]
    again = Permanent(store)
    again.load()
    assert again.V == permanent.V


def test_both_ends_are_kept() -> None:
    store = MemoryStore()
    permanent = Permanent(store)
    permanent.load()
    permanent.V[1], permanent.V[COUNT] = 11, 22
    permanent.keep()
    assert (words(store)[1], words(store)[COUNT]) == (11, 22)


@pytest.mark.manual("ARP-061")
def test_variables_are_in_the_ram_before_an_output_shows_them() -> None:
    class Wires(RecordedLink[Signal]):
        def send(self, message: Signal) -> None:
            if bench is not None:
                shown.append((words(store)[1:], bench.access.V[1:]))

    shown: list[tuple[list[int], list[int]]] = []
    store, bench = MemoryStore(), None
    bench = CardBench("LOOP:\nV1 += 1\nV[V2] += 1\nO101 == !O101\nGOTO LOOP", store=store, wires=Wires())
    bench.put_variable(2, 700)
    bench.run_for(200)
    assert len(shown) > 50
    assert all(kept == there for kept, there in shown)


def test_what_comes_from_outside_is_kept_at_once() -> None:
    store = MemoryStore()
    assert CardBench(store=store).access.set_variables(999, [1, 2])
    assert words(store)[999:] == [1, 2]


@pytest.mark.parametrize(
    ("first", "values"), [(0, [1]), (1000, [1, 2]), (1001, [1]), (-1, [1]), (5, [2**31]), (5, [-(2**31) - 1])]
)
def test_what_does_not_fit_changes_nothing(first: int, values: list[int]) -> None:
    bench = CardBench()
    assert not bench.access.set_variables(first, values)
    assert not any(bench.access.V)
