"""The questions to ask a running rig about the faults of one part: of a bus with a model, of a device, or of every end
of a bus whose medium is outside the rig.

`about_faults` is a generator, so that a command without an event loop and a process with one ask in the same way: it
yields questions, is sent their answers, and returns the whole answer.  A ControlError is thrown into it for a question
that was refused, and its NoAnswerError for one that nothing has answered.
"""

from collections.abc import Generator, Iterable, Mapping
from typing import Any, Final, NamedTuple

from fieldrig.control.messages import Client, NoAnswerError
from fieldrig.errors import ControlError
from fieldrig.faults.condition import check_possible, condition_of
from fieldrig.text.nearest import closest

NAMING: Final = ("node", "receivers")
"""The keys of faults of a CAN bus that name its members."""


class Question(NamedTuple):
    path: str
    message: Any = None
    of_all: bool = False
    """True if all that the `*` in the path stands for are asked; the answer has theirs by name."""


Asking = Generator[Question, Any, Any]


def ask(client: Client, asking: Asking) -> Any:
    """Ask everything that `asking` wants to know, and return what it returns."""
    try:
        question = next(asking)
        while True:
            try:
                asked = client.ask_all if question.of_all else client.ask
                answer = asked(question.path, question.message)
            except ControlError as refusal:
                question = asking.throw(refusal)
            else:
                question = asking.send(answer)
    except StopIteration as end:
        return end.value


def about_faults(where: str, verb: str, message: Any) -> Asking:
    """Ask a bus or device `faults`, `add_fault` or `clear_fault` (`fault_questions.py`).

    ControlError for a part or a member that the rig does not have, or for a part that does not answer.
    """
    rig = yield Question("rig/status")
    known, devices = rig["buses"], rig["devices"]
    if where not in known and where not in devices:
        raise ControlError(f"{rig['rig']} has no bus or device {where!r}", closest(where, [*known, *devices]))
    if verb == "add_fault":
        if where in known:
            check_members(message["fault"], list(devices))
        yield from _check_condition(message["fault"], list(devices), list(known))
    try:
        return (yield Question(f"{'bus' if where in known else 'device'}/{where}/{verb}", message))
    except NoAnswerError:
        if where in devices or any(where in process["buses"] for process in rig["processes"].values()):
            raise
    ends = yield Question(f"end/{where}/*/faults", of_all=True)
    if not ends:
        raise ControlError(
            f"{where}: {known[where]['kind']} takes no faults, because its medium is outside the rig",
            "add the fault to a device that takes some: `fieldrig fault DEVICE` shows which",
        )
    return (yield from _of_ends(where, ends, verb, message))


def check_members(fault: Mapping[str, Any], devices: list[str]) -> None:
    """Check the members of a bus that a fault names.  Those from outside, such as `socketcand:1`, come and go."""
    for key in NAMING:
        for name in _names(fault.get(key, "")):
            if name and ":" not in name and name not in devices:
                raise ControlError(f"{key}: there is no device {name!r}", closest(name, devices))


def _check_condition(fault: Mapping[str, Any], devices: list[str], buses: list[str]) -> Asking:
    """Check that the point of a condition exists; its device or bus may run in another process than the fault."""
    when = fault.get("when")
    try:
        condition = condition_of(when) if isinstance(when, str) else None
    except ValueError:
        return  # what takes the fault says what is wrong
    if condition is None:
        return
    device, key = condition.device, condition.key
    if device in buses:
        present, states = (yield from _signal(device, key)), ()
        if present is None:
            return
    elif device in devices:
        present = (yield Question(f"device/{device}/get", {"keys": [key]}))[key]
        facts = yield Question(f"device/{device}/keys")
        states = facts.get(key, {}).get("states", ())
    else:
        raise ControlError(f"when: there is no device {device!r}", closest(device, [*devices, *buses]))
    check_possible(condition, present, states)


def _signal(bus: str, name: str) -> Asking:
    """Return the present value of a signal; None where the rig itself knows better, as in virtual time."""
    try:
        return (yield Question(f"condition/{bus}/present", {"key": name}))["value"]
    except NoAnswerError:
        pass
    try:
        return (yield Question(f"bus/{bus}/keys")).get(name, {}).get("value")
    except NoAnswerError:
        raise ControlError(
            f"when: {bus} has no process of its own that knows its signals",
            "name the point of a device that drives or hears the signal",
        ) from None


def _names(given: Any) -> Iterable[str]:
    """Return the names in a value of a fault, which may be a text as a person types it, such as `[io, axis]`."""
    names = given if isinstance(given, list | tuple) else str(given or "").strip("[]").split(",")
    return (str(name).strip(" '\"") for name in names)


def _of_ends(bus: str, ends: Mapping[str, Any], verb: str, message: Any) -> Asking:
    """Ask every end of a bus without a model; each has the fault under the same number (`end_questions.py`)."""
    there = _of_all(ends)
    if verb == "faults":
        return there
    if verb == "add_fault":
        given = yield Question(f"end/{bus}/*/given", of_all=True)
        number = 1 + max(given.values())
        having = []
        try:
            for device in ends:
                yield Question(f"end/{bus}/{device}/add_fault", {**message, "number": number})
                having.append(device)
        except ControlError:
            for device in having:  # an end that cannot know the condition of the fault: none has it
                yield Question(f"end/{bus}/{device}/clear_fault", {"number": number})
            raise
        return {"number": number}
    numbers = [int(number) for number in there] if message["number"] is None else [message["number"]]
    for number in numbers:
        having = [device for device, faults in ends.items() if str(number) in faults]
        if not having:
            raise ControlError(f"{bus}: there is no fault {number}", f"there are: {', '.join(there) or 'none'}")
        for device in having:
            yield Question(f"end/{bus}/{device}/clear_fault", {"number": number})
    return {"cleared": numbers}


def _of_all(ends: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the faults of all ends by number, with the sum of `applied`."""
    there: dict[str, dict[str, Any]] = {}
    for faults in ends.values():
        for number, fault in faults.items():
            applied = there.get(number, {}).get("applied", 0)
            there[number] = {**fault, "applied": applied + fault["applied"]}
    return dict(sorted(there.items(), key=lambda item: int(item[0])))
