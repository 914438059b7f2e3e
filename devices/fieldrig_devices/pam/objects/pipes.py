"""The pipes of an application: which blocks live, and what each basic cycle computes (section 2.18 of the digest).

All pipes from one source are a network with one period and phase.  When a pipe begins or ends, its network is laid out
again as a flat list of steps, so that a shared block computes once and a cycle only calls one step after another.

A network sleeps while another period would change nothing in it.  For this, each block and each destination says
whether the value that it took last, taken once more, would leave it as it is (`is_at_rest`).  The network sleeps when
this is so for all of them, and when each branch would get the value that it took last.  It wakes with another value of
its source, and with everything that is counted in `Site.changes`.  Networks that share a block do not sleep, because
each changes what the other has left in it.
"""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import chain
from typing import Final

from fieldrig.shortcuts import Shortcut
from fieldrig_devices.pam.objects.axes_set import AxesSet
from fieldrig_devices.pam.objects.axis import Axis
from fieldrig_devices.pam.objects.corrector_item import CorrectorItem
from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.object_item import ObjectItem
from fieldrig_devices.pam.objects.site import Site
from fieldrig_devices.pam.objects.sources import SourceItem
from fieldrig_devices.pam.objects.transformer_item import TransformerItem
from fieldrig_devices.pam.objects.transformers import DistributorItem
from fieldrig_devices.pam.pipes.block import Block, is_same
from fieldrig_devices.pam.pipes.converter import Converter, Destination
from fieldrig_devices.pam.pipes.distributor import Distributor

Step = Callable[[float], float]
OVERRUN: Final = "02..F060"
SLEEP: Final = Shortcut("pam.pipes.sleep", "a network of pipes in which nothing would change is not computed")


class ConverterItem(ObjectItem):
    """The end of a pipe in programs; most functions are only for an axes set (PAML-481)."""

    def __init__(self, declared: Declared, site: Site, destination: Destination, pipes: "Pipes") -> None:
        super().__init__(declared.name)
        self._site, self._pipes, self.destination = site, pipes, destination
        self.block = Converter(destination, declared.word("MODE"))  # type: ignore[arg-type]

    def ask_ready(self) -> bool:
        return self.block.ready

    def do_disactivate(self) -> None:
        self._pipes.end(self)

    do_deactivate = do_disactivate

    def do_connect(self, *axes: Axis) -> None:
        self._set().connect(axes)

    def do_connect_all(self) -> None:
        self._set().connect(self._set().axes)

    def do_disconnect(self, *axes: Axis) -> None:
        self._set().disconnect(axes)

    def do_disconnect_all(self) -> None:
        self._set().disconnect(self._set().axes)

    def do_change_ratio(self, axis: Axis, ratio: float) -> None:
        self._set().change_ratio([axis], ratio)

    def do_change_all_ratios(self, ratio: float) -> None:
        self._set().change_ratio(self._set().axes, ratio)

    def _set(self) -> AxesSet:
        if not isinstance(self.destination, AxesSet):
            return AxesSet(self.name, self._site, (), optimizes=False)
        return self.destination


class Pipe:
    """An active pipe, from its source to its converter."""

    def __init__(self, blocks: Sequence[ObjectItem]) -> None:
        self.converter: ConverterItem = blocks[0]  # type: ignore[assignment]
        self.source: SourceItem = blocks[-1]  # type: ignore[assignment]
        self.transformers: list[TransformerItem] = list(reversed(blocks[1:-1]))  # type: ignore[arg-type]

    @property
    def lives(self) -> "list[SourceItem | TransformerItem]":
        """The blocks with a life of their own."""
        return [self.source, *self.transformers]

    @property
    def distributor(self) -> Distributor | None:
        distributors = [item.block for item in self.transformers if isinstance(item, DistributorItem)]
        return distributors[0] if distributors else None

    @property
    def period_s(self) -> float:
        return self.source.period * (self.distributor.divisor if self.distributor is not None else 1)


class Flag:
    """The last `ready` of a block that programs know of, which wait for its change; None if they may know another."""

    __slots__ = ("block", "name", "was_ready")

    def __init__(self, item: "SourceItem | TransformerItem | ConverterItem") -> None:
        self.block, self.name = item.block, item.name
        self.was_ready: bool | None = self.block.ready


class Branch:
    """The steps of a pipe behind the blocks that it shares with the pipes in front of it."""

    def __init__(self, pipe: Pipe, begin: TransformerItem | None, steps: Sequence[Step]) -> None:
        self.begin = begin.block if begin is not None else None
        self.distributor, self.steps = pipe.distributor, tuple(steps)
        self.blocks: list[Block | Converter] = [item.block for item in pipe.transformers]
        self.blocks.append(pipe.converter.block)
        self.taken: float | None = None
        """The value that went through the branch last; None if another one has to, because of a change in it."""
        changing = [item for item in pipe.transformers if type(item.block).ready is not Block.ready]
        self.flags = [*map(Flag, changing), Flag(pipe.converter)]
        self.correctors = tuple(item for item in pipe.transformers if isinstance(item, CorrectorItem))

    def is_due(self, number: int) -> bool:
        """Return whether the branch computes in a period of the network."""
        distributor = self.distributor
        return distributor is None or distributor.computes_in(number)

    def arriving(self, first: float) -> float:
        """Return the value that arrives when `first` leaves the source."""
        return first if self.begin is None else self.begin.value

    def is_at_rest(self, first: float) -> bool:
        """True if a period in which `first` leaves the source would change nothing."""
        return is_same(self.arriving(first), self.taken) and all(
            block.is_at_rest and math.isfinite(block.value) for block in self.blocks
        )


class Network:
    """The pipes of one source."""

    def __init__(self, source: SourceItem, site: Site) -> None:
        self._source, self._site = source, site
        self._cycles = round(source.period / site.cycle_s)
        self._left = 1
        self._number = 0
        """Number of the present period, which the distributors count (PAML-542)."""
        self._flags = (Flag(source),)
        self._branches: list[Branch] = []
        self._correcting: list[Branch] = []
        """The branches with correctors, which have to know when the last value was due."""
        self._last: float | None = None
        self._changes = -1
        """The number of changes (`Site.changes`) that the last period knew of."""
        self._is_asleep = False
        self._may_sleep = False

    def lay_out(self, pipes: Sequence[Pipe], *, is_alone: bool) -> None:
        """Lay out the steps: each pipe goes on behind the last block that a pipe before it computes.

        `is_alone` is False if another network computes one of the blocks as well.
        """
        self._may_sleep = is_alone and SLEEP.is_taken
        done: set[int] = set()
        self._branches = []
        self._is_asleep = False
        for pipe in pipes:
            fresh = [item for item in pipe.transformers if id(item) not in done]
            shared = [item for item in pipe.transformers if id(item) in done]
            done.update(id(item) for item in fresh)
            steps = [item.block.pass_on for item in fresh]
            steps.append(pipe.converter.block.pass_on)
            self._branches.append(Branch(pipe, shared[-1] if shared else None, steps))
        self._correcting = [branch for branch in self._branches if branch.correctors]

    @property
    def most_blocks(self) -> int:
        """The blocks that would compute in a period without distributors, with the source."""
        return 1 + sum(len(branch.steps) for branch in self._branches)

    @property
    def due_blocks(self) -> int:
        """The blocks that the PAM computes in this basic cycle, whether or not their values change."""
        if self._left > 1:
            return 0
        return 1 + sum(len(branch.steps) for branch in self._branches if branch.is_due(self._number))

    def flow(self) -> None:
        self._left -= 1
        if self._left:
            return
        self._left = self._cycles
        first = self._source.block.step()
        number, self._number = self._number, self._number + 1
        if self._changes != self._site.changes:
            self._wake()
        is_new = first != self._last or (not first and not is_same(first, self._last))
        self._last = first
        if is_new or not self._is_asleep:
            self._is_asleep = False
            self._compute(first, number)
            self._is_asleep = not is_new and self._may_sleep and self._is_at_rest(first)
        elif self._correcting:
            self._date(number)

    def _wake(self) -> None:
        """Have each branch compute at least once, and tell programs of each `ready` again.

        A command that is carried out within a period ends as it began, but programs have seen it under way.
        """
        self._changes, self._is_asleep = self._site.changes, False
        for branch in self._branches:
            branch.taken = None
        for flag in chain(self._flags, *(branch.flags for branch in self._branches)):
            flag.was_ready = None

    def _is_at_rest(self, first: float) -> bool:
        """True if no further period changes anything, as long as `first` leaves the source."""
        return self._source.block.ready and all(branch.is_at_rest(first) for branch in self._branches)

    def _date(self, number: int) -> None:
        """Note that a value has flowed into the correctors, though it was the same: events are dated by it."""
        for branch in self._correcting:
            if branch.is_due(number):
                for corrector in branch.correctors:
                    corrector.flowed_in = self._site.cycle

    def _compute(self, first: float, number: int) -> None:
        """Take a value of the source through all branches that compute in this period of the network."""
        cycle = self._site.cycle
        self._show(self._flags)
        for branch in self._branches:
            if branch.distributor is not None and not branch.is_due(number):
                continue
            for corrector in branch.correctors:
                corrector.flowed_in = cycle
            value = taken = first if branch.begin is None else branch.begin.value  # as `arriving`, without the call
            for step in branch.steps:
                value = step(value)
            branch.taken = taken
            self._show(branch.flags)

    def _show(self, flags: Sequence[Flag]) -> None:
        for flag in flags:
            ready = flag.block.ready
            if ready is not flag.was_ready:
                flag.was_ready = ready
                self._site.kernel.touched(flag.name)


class Pipes:
    """All active pipes."""

    def __init__(self, site: Site) -> None:
        self._site = site
        self._declared: dict[str, Declared] = {}
        self._pipes: list[Pipe] = []
        self._networks: dict[str, Network] = {}
        self._most_blocks = max(1, site.readings.blocks_per_ms * site.kernel.thirds // 3)
        self._may_overrun = False
        """True if the networks have more blocks than a basic cycle has time for."""
        site.periods_changed = self._hand_periods_on

    def declare(self, declared: Declared) -> None:
        """Keep the declaration of a block, for blocks that begin with its values."""
        self._declared[declared.name] = declared

    def connect(self, blocks: Sequence[ObjectItem]) -> None:
        """Make and activate a pipe, which takes the place of the one with the same destination (PAML-407)."""
        pipe = Pipe(blocks)
        replaced = [known for known in self._pipes if known.converter.destination is pipe.converter.destination]
        kept = [known for known in self._pipes if known not in replaced]
        for known in replaced:
            if known.converter is not pipe.converter:
                known.converter.block.give_up()
                self._site.kernel.touched(known.converter.name)
        pipe.converter.block.start(pipe.period_s)
        self._site.kernel.touched(pipe.converter.name)  # a converter that was ready is so again with its first value
        self._change([*kept, pipe])

    def end(self, converter: ConverterItem) -> None:
        """Dissolve the pipe of a converter (PAML-406)."""
        ended = [pipe for pipe in self._pipes if pipe.converter is converter]
        if ended:
            converter.block.stop()
            self._change([pipe for pipe in self._pipes if pipe not in ended])
            self._site.kernel.touched(converter.name)

    def _change(self, pipes: list[Pipe]) -> None:
        """Let blocks without a pipe end and new ones begin (PAML-409), and lay out the networks."""
        before = {id(item): item for pipe in self._pipes for item in pipe.lives}
        after = {id(item): item for pipe in pipes for item in pipe.lives}
        for key, item in before.items():
            if key not in after:
                item.end()
                self._site.kernel.touched(item.name)
        self._pipes = pipes
        for pipe in pipes:
            self._begin(pipe, before)
            before.update((id(item), item) for item in pipe.lives)
        self._hand_periods_on()
        sources = {pipe.source.name: pipe.source for pipe in pipes}
        self._networks = {
            name: self._networks.get(name) or Network(source, self._site) for name, source in sources.items()
        }
        places = {(id(item), pipe.source.name) for pipe in pipes for item in pipe.transformers}
        shared = Counter(block for block, _ in places)
        for name, network in self._networks.items():
            own = [pipe for pipe in pipes if pipe.source.name == name]
            is_alone = all(shared[id(item)] == 1 for pipe in own for item in pipe.transformers)
            network.lay_out(own, is_alone=is_alone)
        self._may_overrun = sum(network.most_blocks for network in self._networks.values()) > self._most_blocks

    def _begin(self, pipe: Pipe, living: "dict[int, SourceItem | TransformerItem]") -> None:
        """Let the new blocks of a pipe begin."""
        for item in pipe.lives:
            if id(item) not in living:
                item.declare(self._declared[item.name])
                item.begin(pipe.source.period if item is pipe.source else pipe.period_s)
                self._site.kernel.touched(item.name)

    def _hand_periods_on(self) -> None:
        """Hand the period of the values from block to block (PAML-410)."""
        self._site.changes += 1
        for pipe in self._pipes:
            period = pipe.source.block.outgoing_period
            for transformer in pipe.transformers:
                transformer.block.period = period
                period = transformer.block.outgoing_period

    def flow(self) -> None:
        """Compute all networks that are due; too many blocks are a fatal error (PAML-412)."""
        if self._may_overrun and sum(network.due_blocks for network in self._networks.values()) > self._most_blocks:
            self._site.kernel.report(OVERRUN)
            return
        for network in tuple(self._networks.values()):
            network.flow()
