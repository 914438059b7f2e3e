"""Axes sets: several axes under one name, in orders and behind a pipe (section 2.8 of the language's digest)."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final

from fieldrig_devices.pam.objects.axis import Axis
from fieldrig_devices.pam.objects.object_item import ObjectItem
from fieldrig_devices.pam.objects.pipe_input import PipeInput
from fieldrig_devices.pam.objects.site import Site
from fieldrig_devices.pam.pipes.converter import Input, Mode
from fieldrig_devices.pamring.frames import Group, SetPoint
from fieldrig_devices.pamring.registers import Parameter, parameter_address

_CODES = (Parameter.CKV, Parameter.CKA, Parameter.CKR, Parameter.CKH, Parameter.EQUIP)
COMPARED: Final = tuple(map(parameter_address, _CODES))
"""The parameters of identical axes, as addresses of table 2-2 (PAML-163)."""


class Member:
    """An axis of a set, with its switch behind the converter and its ratio (PAML-171, PAML-172)."""

    def __init__(self, axis: Axis, subset: int) -> None:
        self.axis, self.subset = axis, subset
        self.is_connected = True
        self.ratio = 1.0
        self.group = 0
        self.pipe: PipeInput | None = None
        self.parameters: dict[int, int] = {}
        """The parameters of the ST1 that decide whether axes are identical, once they are known."""

    @property
    def is_known(self) -> bool:
        """True if the node has reported all of them; otherwise the axis is in no group."""
        return len(self.parameters) == len(COMPARED)


class AxesSet(ObjectItem):
    def __init__(self, name: str, site: Site, members: Sequence[tuple[Axis, int]], *, optimizes: bool) -> None:
        super().__init__(name)
        self._site = site
        self.members = [Member(axis, subset) for axis, subset in members]
        for axis, _ in members:
            site.dependents.setdefault(axis.name, []).append(name)
        self._optimizes = optimizes
        self._subsets = sorted({member.subset for member in self.members} - {0})
        self._groups: dict[int, list[Member]] = {}
        self._mode: Mode | None = None
        self._period_s = 0.0
        self._value: float | None = None
        """The last value of the flow."""
        if optimizes:
            site.events.append(self._analyse)
        self._work: dict[
            int, tuple[list[tuple[float, Callable[[float], None]]], list[tuple[float, int, list[PipeInput]]]]
        ] = {}
        """The single axes with their ratios, and the groups with those of their axes, by the subset."""
        self._turn = 0

    @property
    def axes(self) -> list[Axis]:
        return [member.axis for member in self.members if member.axis.node.is_active]

    # ---- orders and inquiries

    def do(self, function: str, arguments: Sequence[Any] = ()) -> None:
        """Give an order to all axes; equal orders to the whole of a group are one frame (PAML-162)."""
        number = self._site.next_number({axis.ordered for axis in self.axes})
        orders = {id(axis): axis.carry_out(function, tuple(arguments), number) for axis in self.axes}
        for group, members in self._groups.items():
            distinct = {orders[id(member.axis)] for member in members}
            if len(distinct) == 1:
                self._site.port.send_to_group(group, distinct.pop())
                for member in members:
                    del orders[id(member.axis)]
        for axis in self.axes:
            if id(axis) in orders:
                axis.node.send(orders[id(axis)])
        if function == "stop":
            self._disconnected(self.members)

    def ask(self, function: str, arguments: Sequence[Any] = ()) -> Any:
        """Answer for all axes: errors and bits of any of them, ready if all are; numbers are those of the first."""
        answers = [axis.ask(function, arguments) for axis in self.axes]
        if function in ("ready", "pipe_motionless"):
            return all(answers)
        if function in ("error", "error_code", "status"):
            return any(answers) if arguments or function == "error" else _united(answers)
        return answers[0] if answers else 0.0

    # ---- the end of a pipe

    def attach(self, mode: Mode, period_s: float) -> Input:
        self._mode, self._period_s, self._turn, self._value = mode, period_s, 0, None
        if self._subsets:
            self._site.every_cycle[self.name] = self._serve
        for member in self.members:
            self._join(member)
        self._regroup()
        return self

    def detach(self) -> None:
        self._site.every_cycle.pop(self.name, None)
        self._end([member for member in self.members if member.pipe is not None])
        self._mode = None
        self._regroup()

    def _join(self, member: Member) -> None:
        if self._mode is not None and member.is_connected and member.axis.node.is_active:
            period_s = self._site.cycle_s * len(self._subsets) if member.subset else self._period_s
            member.pipe = member.axis.join(self._mode, period_s, self._stop_all)

    def _end(self, members: Sequence[Member]) -> None:
        """End the pipe for some of the members, unless another one drives the axis."""
        for member in members:
            if member.axis.pipe is member.pipe:
                member.axis.detach()
            member.pipe = None

    def _stop_all(self) -> None:
        self.do("stop")

    def _disconnected(self, members: Sequence[Member]) -> None:
        for member in members:
            if member.pipe is not None:
                member.is_connected, member.pipe = False, None
        self._regroup()

    def connect(self, axes: Sequence[Axis]) -> None:
        for member in self._of(axes):
            if not member.is_connected:
                member.is_connected = True
                self._join(member)
        self._regroup()

    def disconnect(self, axes: Sequence[Axis]) -> None:
        members = [member for member in self._of(axes) if member.is_connected]
        self._end([member for member in members if member.pipe is not None])
        for member in members:
            member.is_connected = False
        self._regroup()

    def change_ratio(self, axes: Sequence[Axis], ratio: float) -> None:
        for member in self._of(axes):
            member.ratio = float(ratio)
        self._regroup()

    def _of(self, axes: Sequence[Axis]) -> list[Member]:
        return [member for member in self.members if any(member.axis is axis for axis in axes)]

    # ---- groups and the flow

    def _regroup(self) -> None:
        """Form the groups of identical axes, and tell the nodes which have changed (PAML-163, PAML-164)."""
        self._site.changes += 1
        wanted = self._identical() if self._optimizes and self._mode is not None else []
        kept = {group: members for group, members in self._groups.items() if members in wanted}
        for group, members in self._groups.items():
            if group not in kept:
                self._site.free_groups.append(group)
                self._name_group(0, members)
        self._groups = kept
        for members in wanted:
            if members not in kept.values() and self._site.free_groups:
                self._site.free_groups.sort()
                group = self._site.free_groups.pop(0)
                self._groups[group] = members
                self._name_group(group, members)
        self._compile()

    def _analyse(self) -> None:
        """Read the parameters of all axes, at the first cycle of the programs (PAML-163)."""
        for member in self.members:
            for address in COMPARED:
                self._site.read(member.axis.node, address, partial(self._on_parameter, member, address))

    def _on_parameter(self, member: Member, address: int, value: int | None) -> None:
        if value is not None:
            member.parameters[address] = value
        if member.is_known and self._mode is not None:
            self._regroup()

    def _identical(self) -> list[list[Member]]:
        by_parameters: dict[tuple[float, ...], list[Member]] = {}
        for member in self.members:
            if member.pipe is not None and member.is_known:
                parameters = (member.parameters[address] for address in COMPARED)
                key = (member.axis.units, member.ratio, member.subset, *parameters)
                by_parameters.setdefault(key, []).append(member)
        return [members for members in by_parameters.values() if len(members) > 1]

    def _name_group(self, group: int, members: Sequence[Member]) -> None:
        for member in members:
            member.group, member.axis.is_grouped = group, group > 0
            member.axis.node.send(Group(group))

    def _compile(self) -> None:
        """Lay out the work of each turn: the inputs of single axes, and the groups, by their subset."""
        self._work = {subset: ([], []) for subset in (0, *self._subsets)}
        for member in self.members:
            if member.pipe is not None and not member.group:
                self._work[member.subset][0].append((member.ratio, member.pipe.take))
        for group, members in self._groups.items():
            pipes = [member.pipe for member in members if member.pipe is not None]
            self._work[members[0].subset][1].append((members[0].ratio, group, pipes))

    def take(self, value: float) -> None:
        """Serve the axes without a subset at once (PAML-168)."""
        self._value = value
        self._serve_subset(0)

    @property
    def is_at_rest(self) -> bool:
        """True if the axes without a subset are; the others take the last value in their turns (`_serve`)."""
        return all(member.pipe.is_at_rest for member in self.members if member.pipe is not None and not member.subset)

    def _serve(self) -> None:
        """Serve the subset whose basic cycle it is, with the last value of the flow."""
        if self._value is not None:
            self._serve_subset(self._subsets[self._turn % len(self._subsets)])
            self._turn += 1

    def _serve_subset(self, subset: int) -> None:
        value = self._value or 0.0
        singles, groups = self._work[subset]
        for ratio, take in singles:
            take(value * ratio)
        for ratio, group, pipes in groups:
            self._serve_group(group, pipes, value * ratio)

    def _serve_group(self, group: int, pipes: Sequence[PipeInput], value: float) -> None:
        """Send one set-point to the axes of a group, if it is new for any of them."""
        set_point = 0
        for pipe in pipes:
            set_point = pipe.follow(value)
        if [pipe for pipe in pipes if pipe.sent != set_point]:
            for pipe in pipes:
                pipe.note(set_point)
            self._site.port.send_to_group(group, SetPoint(pipes[0].set_point_mode, set_point))


def _united(answers: Sequence[int]) -> int:
    bits = 0
    for answer in answers:
        bits |= answer
    return bits
