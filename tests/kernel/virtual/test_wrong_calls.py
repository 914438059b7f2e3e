"""Mistakes in calls from Python: each is refused with its name and a remedy, and changes nothing."""

import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from fieldrig import MS, ArgumentError, ControlError, LiveRig, Rig, RigError, S, from_dict, load
from fieldrig.testing import free_port, plain_forms, return_port

RIG: dict[str, Any] = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}, "can0": {"kind": "can.virtual", "bitrate": 500_000}},
    "devices": {"dice": {"kind": "rig_kinds:Dice", "links": {"wires": "wires"}}},
}
FILE = Path(__file__).parents[3] / "configs" / "lab.yaml"
_any: Any = lambda value: value  # noqa: E731  what mypy would find at once is what is called here


def rig_of() -> Rig:
    return Rig(from_dict(RIG, Path(__file__).parents[1]))


@pytest.fixture
def rig() -> Iterator[Rig]:
    """A rig at 20 ms."""
    with rig_of() as rig:
        rig.run_until(20 * MS)
        yield rig


NO_DEVICE = (r"the rig has no device 'dise'", r"did you mean dice\?")
NO_BUS = (r"the rig has no bus 'can'", r"did you mean can0\?")
NO_PART = (r"the rig has no bus or device 'can'", r"did you mean can0\?")
A_BUS = (r"'can0' is a bus, not a device", "there are: dice")
A_DEVICE = (r"'dice' is a device, not a bus", "there are: wires, can0")
DURATION = "expected a duration in whole nanoseconds, such as 10 \\* MS"

WRONG: dict[str, list[tuple[tuple[Any, ...], tuple[str, str]]]] = {
    "run_until": [
        ((5 * MS,), (r"run_until cannot go back to 0.005 s: the rig is at 0.02 s", r"run_for\(10 \* MS\)")),
        ((30 * MS, 5), (r"run_until cannot call 5", "expected a function without arguments")),
        ((-1,), (r"run_until cannot go back to -0.000000001 s", r"run_for\(10 \* MS\)")),
        ((1.5,), ("time is a whole number of nanoseconds, not 1.5", r"round\(seconds")),
        (("10",), ("time is a whole number of nanoseconds, not '10'", r"round\(seconds")),
    ],
    "run_for": [((-1,), (r"run_for cannot take -1", DURATION)), ((0.5,), (r"run_for cannot take 0.5", DURATION))],
    "until": [
        ((False, S), (r"until cannot take False", "expected a function, such as until\\(lambda: rig")),
        ((lambda: True, -1), (r"until cannot take -1", DURATION)),
    ],
    "stays": [
        ((False, S), (r"stays cannot take False", "expected a function, such as stays\\(lambda: rig")),
        ((lambda: True, -1), (r"stays cannot take -1", DURATION)),
        ((lambda: True, S, 5), (r"stays cannot take 5", "expected a function, such as stays")),
    ],
    "never": [
        ((False, S), (r"never cannot take False", "expected a function, such as never\\(lambda: rig")),
        ((lambda: False, 0.5), (r"never cannot take 0.5", DURATION)),
    ],
    "interests": [(("can",), NO_BUS), (("dice",), A_DEVICE)],
    "on_change": [
        (("dise/throws", print), NO_DEVICE),
        (("can0/load", print), A_BUS),
        (("dice/throw", print), ("dice has no value 'throw'", "did you mean throws")),
        (("dice", print), ("'dice' is not a point", "expected DEVICE/KEY")),
        (("dice/throws", None), (r"on_change cannot call None", "expected a function")),
    ],
    "on_delivery": [((None,), (r"on_delivery cannot call None", "expected a function"))],
    "on_instant": [((5,), (r"on_instant cannot call 5", "expected a function"))],
    "branch": [(("5",), (r"a seed cannot be '5'", "expected a whole number"))],
    "branches": [
        ((5, [1]), (r"branches cannot call 5", "expected a function that takes a rig and a seed")),
        ((print, 5), (r"seeds cannot be 5", r"such as range\(100\)")),
        ((print, [1.5]), (r"a seed cannot be 1.5", "expected a whole number")),
        ((print, [1], 0), (r"branches cannot have 0 workers", "expected at least 1")),
    ],
    "call": [((5,), (r"call cannot take 5", "expected a function that takes a rig"))],
    "checkpoint_every": [
        ((0,), (r"checkpoint_every cannot take 0", r"expected a period, such as 5 \* S")),
        ((1.5,), (r"checkpoint_every cannot take 1.5", r"expected a period")),
        ((S, 1), (r"checkpoint_every cannot keep 1", "expected at least 2")),
    ],
    "back": [
        ((1.5,), ("time is a whole number of nanoseconds, not 1.5", r"round\(seconds")),
        ((10 * MS,), ("the rig has no checkpoints to go back to", "call checkpoint_every")),
    ],
    "attach": [
        (("dice",), ("the rig already has a member 'dice'", "choose another name")),
        ((5,), (r"a member cannot be called 5", "expected a name")),
        (("",), (r"a member cannot be called ''", "expected a name")),
    ],
    "detach": [
        (("dice",), ("'dice' is not attached", "")),
        ((5,), (r"5 is not attached", "")),
    ],
    "keys": [
        (("dise",), NO_DEVICE),
        (("can0",), A_BUS),
        ((["dice"],), (r"has no device \['dice'\]", "there are|did you")),
    ],
    "facts": [(("dise",), NO_DEVICE), (("can0",), A_BUS)],
    "front": [(("dise",), NO_DEVICE), (("can0",), A_BUS)],
    "values": [
        (("dise",), NO_DEVICE),
        (("can0",), A_BUS),
        (("dice", ["throw"]), ("dice has no value 'throw'", "did you mean throws")),
    ],
    "get": [
        (("dise/throws",), NO_DEVICE),
        (("dise", "throws"), NO_DEVICE),
        (("can0/load",), A_BUS),
        (("dice/throw",), ("dice has no value 'throw'", "did you mean throws")),
        (("dice",), ("'dice' is not a point", "expected DEVICE/KEY")),
    ],
    "set": [
        (("dise/throws", 1), NO_DEVICE),
        (("can0/load", 1), A_BUS),
        (("dice/throw", 1), ("dice has no value 'throw'", "did you mean throws")),
        (("dice/throws", None), (r"throws cannot be None", "expected a number, a text, true or false")),
        (("dice/throws", [1]), (r"throws cannot be \[1\]", "expected a number, a text, true or false")),
        (("dice/throws", -1), (r"throws cannot be -1", "throws are counted from 0")),
        (("dice/throws",), (r"'dice/throws' cannot be set to nothing", "expected a value")),
    ],
    "record": [
        (("dise/throws",), (r"the rig has no device or bus 'dise'", r"did you mean dice\?")),
        (("dice/throw",), ("dice has no value 'throw'", "did you mean throws")),
        (("dice",), ("'dice' is not a signal", "expected DEVICE/KEY")),
        (("wires/x",), ("nothing drives 'x' on wires", "")),
        ((5,), ("record cannot take 5", "expected names")),
        (("dice/throws", "often"), ("record cannot have the rhythm 'often'", 'expected "cycle"')),
    ],
    "signals": [(("can",), NO_BUS), (("dice",), A_DEVICE)],
    "answer": [
        (("dise", "rethrow", None), NO_DEVICE),
        (("can0", "rethrow", None), A_BUS),
        (("dice", "dance", None), (r"this device cannot answer dance", "")),
    ],
    "statistics": [(("can",), NO_BUS), (("dice",), A_DEVICE), (([],), (r"the rig has no bus \[\]", "there are"))],
    "conditions": [(("can",), NO_BUS), (("dice",), A_DEVICE)],
    "add_fault": [
        (("can", {"what": "drop"}), NO_PART),
        (("can0", "drop"), (r"a fault cannot be 'drop'", "expected a mapping")),
        (("can0", {"what": "drip"}), ("can0: .*drip", "")),
        (("dice", {"what": "loadet"}), ("dice: .*loadet", "loaded")),
        (("wires", {"what": "drop"}), (r"wires: there is no fault 'drop'", "did you mean drop_out")),
    ],
    "restart": [(("dise",), NO_DEVICE), (("can0",), A_BUS), (([],), (r"has no device \[\]", "there are|did you"))],
    "clear_fault": [
        (("can", 1), NO_PART),
        (("can0", 1), ("can0: there is no fault 1", "")),
        (("dice", "1"), (r"a fault cannot have the number '1'", "expected what add_fault returned")),
    ],
    "faults": [(("can",), NO_PART), ((None,), ("the rig has no bus or device None", "there are"))],
}
"""Wrong arguments of each call of a rig, with what is said and what would be right."""

TAKE_NOTHING = {"next_ns", "step", "close", "trace_hash", "checkpoints"}


def public_calls() -> set[str]:
    return {name for name, call in inspect.getmembers(Rig, inspect.isfunction) if not name.startswith("_")}


def test_every_call_of_a_rig_has_its_mistakes() -> None:
    assert set(WRONG) == public_calls() - TAKE_NOTHING


@pytest.mark.parametrize(
    ("call", "arguments", "what", "remedy"),
    [(call, arguments, *said) for call, rows in WRONG.items() for arguments, said in rows],
)
def test_a_wrong_argument_is_answered(rig: Rig, call: str, arguments: tuple[Any, ...], what: str, remedy: str) -> None:
    with pytest.raises(RigError, match=f"(?s){what}.*{remedy}") as wrong:
        getattr(rig, call)(*arguments)
    assert isinstance(wrong.value, ArgumentError | ControlError) or call in ("attach", "detach", "back")
    assert (rig.now_ns, rig.get("dice/throws"), rig.faults("can0"), rig.faults("dice")) == (20 * MS, 3, {}, {})


def test_an_error_of_an_argument_is_also_one_of_python() -> None:
    assert issubclass(ArgumentError, TypeError) and issubclass(ArgumentError, ValueError)  # noqa: PT018


@pytest.mark.parametrize("call", sorted(public_calls() - {"close"}))
def test_a_closed_rig_does_nothing_any_more(call: str) -> None:
    with rig_of() as rig:
        pass
    right: dict[str, tuple[Any, ...]] = {
        "run_until": (S,), "run_for": (S,), "until": (lambda: False, S), "stays": (lambda: True, S),
        "never": (lambda: False, S), "interests": ("can0",), "attach": ("bench",), "keys": ("dice",),
        "facts": ("dice",), "front": ("dice",), "values": ("dice",),
        "on_change": ("dice/throws", print), "on_delivery": (print,), "on_instant": (print,), "branches": (print, [1]),
        "call": (print,),
        "checkpoint_every": (S,), "back": (0,), "detach": ("bench",),
        "record": ("dice/throws",), "signals": ("can0",),
        "get": ("dice/throws",), "set": ("dice/throws", 1), "answer": ("dice", "rethrow", {"times": 1}),
        "statistics": ("can0",), "conditions": ("can0",), "add_fault": ("can0", {"what": "drop"}),
        "clear_fault": ("can0", 1), "faults": ("can0",), "restart": ("dice",),
    }  # fmt: skip
    with pytest.raises(RigError, match="the rig is closed\n  use it inside its `with` statement"):
        getattr(rig, call)(*right.get(call, ()))
    rig.close()


@pytest.mark.parametrize(
    ("call", "what"),
    [
        (lambda: load(_any(5)), r"a rig file cannot be 5\n  expected a path, such as load"),
        (lambda: load(_any(None)), r"a rig file cannot be None"),
        (lambda: load(FILE, "seed=3"), r"overrides cannot be 'seed=3'\n  expected a list"),
        (lambda: load(FILE, [_any(5)]), r"overrides cannot be \[5\]"),
        (lambda: from_dict(_any("rig.yaml")), r"a rig cannot be 'rig.yaml'"),
        (lambda: Rig(_any("rig.yaml")), r"a rig cannot be made of 'rig.yaml'\n  write Rig\(load"),
        (lambda: Rig(from_dict({"time": "virtual"}), stores={"dice": _any(None)}), "the rig has no device 'dice'"),
        (lambda: LiveRig(_any(5)), r"a rig cannot be started from 5\n  expected a path"),
        (
            lambda: LiveRig(FILE, _any(3)),
            "a rig cannot be started from .*, 3\n  expected a path, and overrides as texts",
        ),
        (lambda: plain_forms("can.clam").__enter__(), r"there is no shortcut 'can.clam'"),
        (lambda: return_port(-1), r"port -1 cannot be returned\n  expected a port that free_port has given"),
    ],
)
def test_a_rig_is_not_made_of_anything_else(call: Callable[[], object], what: str) -> None:
    with pytest.raises(RigError, match=what):
        call()


def test_a_path_may_be_a_text() -> None:
    assert load(str(FILE)).devices.keys() == load(FILE).devices.keys()
    return_port(free_port())


def test_a_file_that_is_not_there_is_named() -> None:
    with pytest.raises(RigError, match=r"lba\.yaml: .*\n.*did you mean .*lab.yaml"):
        load(FILE.with_name("lba.yaml"))
