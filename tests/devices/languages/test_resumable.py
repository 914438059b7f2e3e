"""All three builds of a program, with any slices, have the same effect as executing the instructions one by one."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.languages.blocks import LONGEST
from fieldrig_devices.languages.instructions import Branch, Call, Do, End, Hold, Instruction, Jump, Pause, Routine
from fieldrig_devices.languages.resumable import Code
from fieldrig_devices.languages.task import Task, TaskState
from fieldrig_devices.languages.writer import SLICE, Build

DEEPEST = 3
NAMES = ("A", "B", "C")
ENOUGH = 120

Routines = dict[str, list[Instruction]]


@st.composite
def routine(draw: st.DrawFn, number: int) -> list[Instruction]:
    length = draw(st.integers(0, 12))
    kinds = st.sampled_from(["do", "do", "do", "branch", "jump", "call", "pause", "hold"])
    instructions: list[Instruction] = []
    for pc in range(length):
        line = 100 * number + pc
        match draw(kinds):
            case "do":
                instructions.append(Do(line, (f"log({line})",)))
            case "branch":
                python = (f"t0 = chance({draw(st.integers(2, 5))})",)
                pause = draw(st.sampled_from(["", "1"]))
                instructions.append(Branch(line, python, "t0", draw(st.integers(0, length)), pause=pause))
            case "jump":
                instructions.append(Jump(line, draw(st.integers(0, length))))
            case "call":
                instructions.append(Call(line, draw(st.sampled_from(NAMES))))
            case "pause":
                instructions.append(Pause(line, (f"log({-line})",), "chance(2)"))
            case "hold":
                instructions.append(Hold(line, "chance(3)"))
    return [*instructions, End(100 * number + 99)]


PROGRAMS = st.tuples(routine(1), routine(2), routine(3)).map(lambda some: dict(zip(NAMES, some, strict=True)))


class World:
    """The tables that a program uses, and its effects on them."""

    def __init__(self, routines: Routines) -> None:
        self.done: list[int] = []
        self._turns = 0
        names = {"log": self.done.append, "chance": self.chance}
        self.code = Code(routines, names, DEEPEST + 1)
        self.task = Task(self.code)
        self.task.start("A")

    def chance(self, every: int) -> int:
        self._turns += 1
        return int(self._turns % every == 0)

    def is_over(self) -> bool:
        return len(self.done) >= ENOUGH or self.task.state in (TaskState.ENDED, TaskState.TOO_DEEP)


def walked(routines: Routines) -> tuple[list[int], bool]:
    """Execute the instructions one by one; return their effects, and whether the program ended by itself."""
    world = World(routines)
    stack: list[tuple[str, int]] = []
    name, pc = "A", 0
    for _ in range(5_000):
        if len(world.done) >= ENOUGH:
            break
        match routines[name][pc]:
            case Do(line):
                world.done.append(line)
                pc += 1
            case Branch(_, python, _, target):
                is_true = world.chance(int(python[0].removeprefix("t0 = chance(").removesuffix(")")))
                pc = target if is_true else pc + 1
            case Jump(_, target):
                pc = target
            case Call(_, called):
                if len(stack) >= DEEPEST:
                    return world.done, True
                stack.append((name, pc + 1))
                name, pc = called, 0
            case Pause(line):
                world.done.append(-line)
                world.chance(2)
                pc += 1
            case Hold():
                pc += not world.chance(3)
            case End():
                if not stack:
                    return world.done, True
                name, pc = stack.pop()
    return world.done, False


def agree(done: list[int], expected: list[int], has_ended: bool) -> bool:
    """Compare two effects as far as both have run, because a slice may exceed its budget, or fully after an end."""
    return done == expected if has_ended else done[: len(expected)] == expected[: len(done)]


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(routines=PROGRAMS, budgets=st.lists(st.integers(1, 40), min_size=1, max_size=4))
def test_slices_do_not_change_what_a_program_does(routines: Routines, budgets: list[int]) -> None:
    expected, has_ended = walked(routines)
    world = World(routines)
    for turn in range(5_000):
        if world.is_over():
            break
        world.task.run(budgets[turn % len(budgets)])
    assert agree(world.done, expected, has_ended and len(expected) < ENOUGH)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(routines=PROGRAMS)
def test_single_steps_do_the_same(routines: Routines) -> None:
    expected, has_ended = walked(routines)
    world = World(routines)
    for _ in range(5_000):
        if world.is_over():
            break
        world.task.step()
    assert agree(world.done, expected, has_ended and len(expected) < ENOUGH)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(routines=PROGRAMS, stops=st.sets(st.integers(100, 312), max_size=20), steps=st.integers(0, 3))
def test_breakpoints_and_steps_between_slices_do_not_change_it_either(
    routines: Routines, stops: set[int], steps: int
) -> None:
    expected, has_ended = walked(routines)
    world = World(routines)
    world.code.stop_at(stops)
    world.task.is_watched = True
    for _ in range(5_000):
        if world.is_over():
            break
        world.task.run(7)
        if world.task.state is TaskState.STOPPED:
            assert world.task.line in stops
            for _ in range(steps):
                world.task.step()
            world.task.go_on()
    assert agree(world.done, expected, has_ended and len(expected) < ENOUGH)


def test_a_slice_runs_over_by_less_than_a_block() -> None:
    world = World({"A": [*(Do(line, (f"log({line})",)) for line in range(500)), Jump(500, 0), End(501)]})
    for _ in range(100):
        before = len(world.done)
        left = world.task.run(10)
        assert -LONGEST < left <= 0
        assert len(world.done) - before <= 10 - left


@pytest.mark.parametrize("is_watched", [False, True])
def test_each_instruction_costs_one_a_call_and_an_end_too(is_watched: bool) -> None:
    world = World(
        {
            "A": [Do(1, ("log(1)",)), Call(2, "B"), Jump(3, 3), Call(4, "B"), End(5)],
            "B": [Do(6, ("log(2)",)), Call(7, "C"), End(8)],
            "C": [Branch(9, (), "chance(1)", 1), End(10)],
        }
    )
    world.task.is_watched = is_watched
    assert world.task.run(100) == 100 - (5 + 2 * (3 + 2))
    assert world.task.state is TaskState.ENDED


def test_a_loop_gives_way_and_goes_on() -> None:
    world = World({"A": [Do(1, ("log(1)",)), Jump(2, 0), End(3)]})
    assert world.task.run(1_000) == 0
    assert len(world.done) == 500
    assert world.task.run(10) == 0
    assert len(world.done) == 505


@pytest.mark.parametrize("is_watched", [False, True])
def test_a_jump_back_ends_the_slice_where_others_wait(is_watched: bool) -> None:
    world = World({"A": [Do(1, ("log(1)",)), Branch(2, (), "1", 0, pause="chance(3)"), End(3)]})
    world.task.is_watched = is_watched
    for slice_ in range(1, 4):
        world.task.run(1_000)
        assert (len(world.done), world.task.has_waited, world.task.pc) == (3 * slice_, True, 0)


def test_a_task_goes_on_at_any_instruction() -> None:
    world = World({"A": [*(Do(line, (f"log({line})",)) for line in range(1, 9)), End(9)]})
    world.task.go_to(5)
    world.task.run(100)
    assert (world.done, world.task.state) == ([6, 7, 8], TaskState.ENDED)


def test_a_breakpoint_stops_in_front_of_its_line_once_per_passage() -> None:
    world = World({"A": [Do(1, ("log(1)",)), Do(2, ("log(2)",)), Do(2, ("log(22)",)), Jump(3, 0), End(4)]})
    assert world.code.stop_at({2, 99}) == {2}
    world.task.is_watched = True
    for passage in range(1, 4):
        world.task.run(1_000)
        assert (world.task.state, world.task.line) == (TaskState.STOPPED, 2)
        assert world.done.count(1) == passage
        assert world.done.count(22) == passage - 1
        world.task.go_on()
    world.code.stop_at(set())
    world.task.run(100)
    assert world.task.state is TaskState.READY


def test_no_breakpoint_is_missed_where_a_slice_ends_between_two_of_them() -> None:
    world = World({"A": [*(Do(line, (f"log({line})",)) for line in range(1, 9)), End(9)]})
    world.code.stop_at(set(range(1, 10)))
    world.task.is_watched = True
    seen = []
    while world.task.state is not TaskState.ENDED:
        world.task.run(1)
        if world.task.state is TaskState.STOPPED:
            seen.append((world.task.line, list(world.done)))
            world.task.go_on()
    assert seen == [(line, list(range(1, line))) for line in range(1, 10)]


def test_a_breakpoint_on_a_line_that_holds_stops_once_and_then_the_line_holds() -> None:
    gate = [1]
    code = Code({"A": [Do(1, ("log(1)",)), Hold(2, "gate[0]"), Do(2, ("log(2)",)), End(3)]},
                {"log": (done := list[int]()).append, "gate": gate}, DEEPEST)  # fmt: skip
    task = Task(code)
    task.start("A")
    code.stop_at({2})
    task.is_watched = True
    task.run(10)
    assert (task.state, done) == (TaskState.STOPPED, [1])
    task.go_on()
    for _ in range(3):
        assert task.run(10) == 0
        assert (task.state, done) == (TaskState.READY, [1])
    gate[0] = 0
    task.run(10)
    assert (task.state, done) == (TaskState.ENDED, [1, 2])


@pytest.mark.parametrize("build", list(Build))
@pytest.mark.long
def test_deep_code_compiles(build: Build) -> None:
    """CPython's parser allows 100 levels of indentation; the tree of blocks needs one per doubling."""
    routine = [Branch(pc, (f"t0 = chance({pc + 2})",), "t0", (pc * 7) % 3_000) for pc in range(3_000)]
    code = Code({"A": [*routine, End(3_000)]}, {"chance": abs, "log": abs}, DEEPEST)
    code.compile(build)
    assert code.functions(build)[0](0, 1, 0, 0)[0] == SLICE


COSTLY: Routines = {
    "A": [
        Branch(1, ("t0 = chance(2)",), "t0", 4, cost=3),
        Do(2, ("log(2)",), cost=5),
        Call(3, "B", cost=7, is_checked=False),
        Jump(4, 5, cost=11),
        Do(5, ("log(5)",), cost=13),
        Branch(6, ("t0 = chance(3)",), "t0", 0, cost=17),
        End(7, cost=19),
    ],
    "B": [Branch(8, (), "chance(2)", 2, cost=23), Do(9, ("log(9)",), cost=29), End(10, cost=31)],
}


@pytest.mark.parametrize("is_watched", [False, True])
@pytest.mark.parametrize("budget", [1, 20, 10_000])
def test_a_program_costs_the_same_in_every_build_and_in_any_slices(budget: int, is_watched: bool) -> None:
    stepped = World(COSTLY)
    expected = 0
    while stepped.task.state is TaskState.READY:
        expected += stepped.task.step()
    world = World(COSTLY)
    world.task.is_watched = is_watched
    used = 0
    while world.task.state is TaskState.READY:
        used += budget - world.task.run(budget)
    assert (world.done, used) == (stepped.done, expected)


def test_a_short_routine_runs_instead_of_its_call() -> None:
    code = World(COSTLY).code
    assert "routine_1(" not in code.source(Build.FAST).split("def routine_1")[0]
    assert "routine_1(" in code.source(Build.WATCHED).split("def routine_1")[0]


def test_a_fault_has_its_place_and_those_of_its_callers() -> None:
    code = Code(
        {
            "A": [Do(1, ("x[0] = 1",)), Call(2, "B"), End(3)],
            "B": [Do(4, ("x[0] = 2",)), Call(5, "C"), End(6)],
            "C": [Do(7, ("x[0] = 3",)), Do(8, ("x[0] = 1 // x[1]", "x[0] = 4")), End(9)],
        },
        {"x": (table := [0, 0])},
        DEEPEST + 1,
    )
    task = Task(code)
    task.start("A")
    task.run(100)
    assert (task.state, task.line, table) == (TaskState.FAULTED, 8, [3, 0])
    assert isinstance(task.fault, ZeroDivisionError)
    assert [(place.routine, code.line(place.routine, place.pc - 1)) for place in task.stack] == [(0, 2), (1, 5)]
    assert task.run(100) == 100


def test_a_fault_that_is_not_the_programs_own_is_not_caught() -> None:
    def broken() -> None:
        raise TypeError("ours")

    task = Task(Code({"A": [Do(1, ("broken()",)), End(2)]}, {"broken": broken}, DEEPEST))
    task.start("A")
    with pytest.raises(TypeError, match="ours"):
        task.run(100)


def test_a_stack_without_room_for_a_frame_ends_the_task() -> None:
    routines = {"A": Routine([Call(1, "B"), End(2)], 60), "B": Routine([Do(3, ("x[0] = 1",)), End(4)], 40)}
    for size, state in ((100, TaskState.ENDED), (99, TaskState.TOO_DEEP)):
        task = Task(Code(routines, {"x": [0]}, size))
        task.start("A", frame=1_000)
        task.run(100)
        assert task.state is state
