"""A walk through the enable chain of an MC-4: every stage, every stimulus, and the stage to which it leads.

The chain is code and no table, so this finds its transitions: from each state that it reaches it tries each stimulus on
a copy.
"""

from collections.abc import Callable, Iterator
from copy import deepcopy
from typing import Final, NamedTuple

from fieldrig.clock import S
from fieldrig_devices.mc4.enable import EnableChain, Limit, Reaction, Seen, Stage, Times


class Step(NamedTuple):
    source: Stage
    target: Stage
    stimulus: str


class _Chain(EnableChain):
    """The chain, which notes the stages that it enters."""

    def __init__(self) -> None:
        super().__init__(Times(), _ignore)
        self.entered: list[Stage] = []

    def _enter(self, stage: Stage, now_ns: int) -> None:
        self.entered.append(stage)
        super()._enter(stage, now_ns)

    def _coast(self, now_ns: int) -> None:
        self.entered.append(Stage.COASTING)
        super()._coast(now_ns)

    def key(self, now_ns: int) -> tuple[object, ...]:
        """Everything on which the next step depends."""
        return self.stage, self.error, self.is_brake_lifted, self._until_ns <= now_ns


class _Walker:
    """A chain with what it sees."""

    def __init__(self) -> None:
        self.chain = _Chain()
        self.seen = Seen(hardware=False, controller=False, can_start=True, is_slow=True)
        self.now_ns = 0

    @property
    def key(self) -> tuple[object, ...]:
        return self.seen, self.chain.key(self.now_ns)

    def see(self, **changes: bool) -> None:
        self.seen = self.seen._replace(**changes)

    def wait(self) -> None:
        self.now_ns += 10 * S

    def react(self, reaction: Reaction) -> None:
        self.chain.react(self.now_ns, reaction)

    def acknowledge(self) -> None:
        if self.chain.can_quit:
            self.chain.quit(self.now_ns)


def _ignore(limit: Limit) -> None:
    """An exceeded limit becomes an error of the diagnosis, which is a stimulus of its own."""


STIMULI: Final[dict[str, Callable[[_Walker], None]]] = {
    "Inverter Enable": lambda walker: walker.see(hardware=True),
    "enable missing": lambda walker: walker.see(hardware=False),
    "ControllerEnable": lambda walker: walker.see(controller=True),
    "enable missing ": lambda walker: walker.see(controller=False),
    "motion": lambda walker: walker.see(is_slow=False),
    "standstill": lambda walker: walker.see(is_slow=True),
    "overload position": lambda walker: walker.see(is_at_overload_position=True),
    "time elapsed": _Walker.wait,
    "reaction A": lambda walker: walker.react(Reaction.A),
    "reaction B": lambda walker: walker.react(Reaction.B),
    "overload": lambda walker: walker.react(Reaction.OVERLOAD),
    "acknowledge": _Walker.acknowledge,
}


def steps() -> Iterator[Step]:
    """The steps from each stage, in the order in which the walk finds them."""
    walkers = [_Walker()]
    known = {walkers[0].key}
    found: dict[Step, None] = {}
    for walker in walkers:
        for name, stimulus in STIMULI.items():
            tried = deepcopy(walker)
            tried.chain.entered.clear()
            stimulus(tried)
            tried.chain.update(tried.now_ns, tried.seen)
            for target in tried.chain.entered[:1]:
                found[Step(walker.chain.stage, target, name.strip())] = None
            if tried.key not in known:
                known.add(tried.key)
                walkers.append(tried)
    return iter(found)
