"""The order of a sweep, and what it is complete of."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from lamp_search import PLAN, planted, searched

from fieldrig.clock import MS, S
from fieldrig_devices.search.choices import Choice
from fieldrig_devices.search.crew import Bench
from fieldrig_devices.search.piece import Piece
from fieldrig_devices.search.plan import load_plan
from fieldrig_devices.search.run import Nominal
from fieldrig_devices.search.strategy import WHOLE, Task
from fieldrig_devices.search.sweep import FIRST, REPEATS, Sweep

LENGTH_NS = 8 * S
PRESS = Choice("press", "a/key", (True,), holds_ns=(100 * MS,))
BREAK = Choice("fault", "ring", ({"what": "break", "duration_ms": 700},))


def sweep(changes: tuple[tuple[int, ...], ...], others: tuple[int, ...], *choices: Choice) -> list[Piece]:
    bench: Any = SimpleNamespace(nominal=Nominal((), changes, others, 0.0), choices=choices)
    plan: Any = SimpleNamespace(scenario=SimpleNamespace(length_ns=LENGTH_NS), worlds=((),))
    strategy = Sweep(Task(plan, bench, 1, WHOLE))
    return list(iter(strategy.piece, None))


def edges(pieces: list[Piece]) -> list[int]:
    return [piece.from_ns for piece in pieces if len(piece.acts) == 1]


def test_the_first_change_of_each_kind_comes_before_the_second_of_any() -> None:
    rising, falling = (1 * S, 3 * S, 5 * S), (6 * S,)
    around = [at_ns + side for at_ns in (1 * S, 6 * S, 3 * S, 5 * S) for side in (-1, 1)]
    assert edges(sweep((rising, falling), (), PRESS)) == around


def test_each_action_comes_just_before_and_after_each_instant_once() -> None:
    changes, others = ((1 * S, 3 * S), (2 * S, 3 * S)), tuple(range(MS, 200 * MS, MS))
    found = edges(sweep(changes, others, PRESS))
    assert sorted(found) == sorted({at_ns + side for at_ns in (S, 2 * S, 3 * S, *others) for side in (-1, 1)})


def test_the_first_other_instants_are_spread_over_the_scenario() -> None:
    others = tuple(range(MS, LENGTH_NS, MS))
    first = edges(sweep((), others, PRESS))[:FIRST]
    assert max(first) > LENGTH_NS // 2


def test_an_action_comes_again_and_again_unless_it_would_not_end() -> None:
    trains = [piece.acts for piece in sweep(((S,),), (2 * S, 4 * S, 6 * S), PRESS, BREAK) if len(piece.acts) > 1]
    counts = {verb: [len(acts) for acts in trains if acts[0].verb == verb] for verb in ("press", "fault")}
    assert counts == {"press": [*REPEATS[:1]], "fault": [*REPEATS[:1]]}
    assert [act.at_ns for act in trains[0]] == [2 * S, 6 * S]
    many = tuple(range(MS, LENGTH_NS, 10 * MS))
    trains = [piece.acts for piece in sweep((), many, PRESS, BREAK) if len(piece.acts) > 1]
    assert [len(acts) for acts in trains if acts[0].verb == "press"] == list(REPEATS)
    assert [len(acts) for acts in trains if acts[0].verb == "fault"] == [2, 4, 8]


@pytest.mark.long
def test_a_place_that_moves_all_the_time_has_no_edges(tmp_path: Path) -> None:
    """A counter of cycles is not what a sweep looks at first; a switch is."""
    plan = PLAN.replace("states:", "edges: [terminal/presses]\nstates:")
    with Bench(load_plan(planted(tmp_path, "presses := presses + 1;", plan))) as bench:
        found = bench.nominal
    assert len(found.others) > 20
    assert sorted(found.changes)[:2] == [
        (100 * MS,),
        (310 * MS,),
    ]  # the switch, and the lamp 200 ms and a cycle after it
    assert sum(map(len, found.changes)) == 4


@pytest.mark.long
def test_strategies_have_the_same_virtual_time(tmp_path: Path) -> None:
    corpus, _ = searched(planted(tmp_path, ""), "sweep", "swarm", most=12)
    names = [strategy for _, strategy, _ in corpus.all_runs()]
    assert {"sweep", "swarm"} == set(names)
    assert names.count("sweep") >= names.count("swarm")  # which always plays from the begin
