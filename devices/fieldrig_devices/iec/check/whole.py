"""Checks of the whole project: the limits of section 1.16, recursion, and sizes with hidden variables."""

from collections.abc import Sequence

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.project import UNKNOWN, Project
from fieldrig_devices.iec.check.sizes import Sizes
from fieldrig_devices.iec.program import Pou, Space, Variable
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import ArrayType, StructType


def check(project: Project, lists: Sequence[tuple[list[Variable], tree.Variables, str]]) -> None:
    sizes = Sizes(project)
    for pou in project.sources:
        if pou.type is not None:
            sizes.of(pou.type)
    _settle(project, sizes)
    for variable in [
        *project.globals.values(),
        *(own for pou in project.sources for own in pou.variables.values()),
    ]:
        _variable(project, sizes, variable)
    _lists(project, sizes, lists)
    _instances(project)
    _totals(project, sizes)
    _stack(project, sizes)
    _recursion(project)


def _settle(project: Project, sizes: Sizes) -> None:
    for element in project.elements:
        element.stride = sizes.of(element.type)
    for constant, kind in project.strides:
        constant.value = sizes.of(kind)
    for component, field in project.components:
        component.offset = field.offset


# ---- PD-316: arrays, structures, lists and instances


def _variable(project: Project, sizes: Sizes, variable: Variable) -> None:
    limit = project.limits.variable
    if not isinstance(variable.type, ArrayType | StructType) or variable.type is UNKNOWN or variable.is_reference:
        return
    size, parts = sizes.of(variable.type), sizes.parts(variable.type)
    most = project.limits.parts
    if parts > most:
        what = f"{variable.name} has {parts} components and elements"
        project.reports.say(variable.file, variable.position, what, f"at most {most}")
    if size > limit:
        project.reports.say(
            variable.file, variable.position, f"{variable.name} has {size} bytes", f"at most {limit} bytes (PD-316)"
        )


def _lists(project: Project, sizes: Sizes, lists: Sequence[tuple[list[Variable], tree.Variables, str]]) -> None:
    limit = project.limits.variable
    for members, block, file in lists:
        size = sum(sizes.variable(variable) for variable in members)
        if size > limit and all(sizes.variable(variable) <= limit for variable in members):
            hint = "divide it into several lists"
            project.reports.say(
                file, block.position, f"this list has {size} bytes", f"at most {limit} bytes (PD-316)", hint
            )


def _instances(project: Project) -> None:
    limit = project.limits.variable
    for pou, source in project.sources.items():
        if any(variable.type.size > limit for variable in pou.variables.values()):
            continue  # the variable has its message
        if pou.kind.has_instances and pou.type is not None and pou.type.size > limit:
            project.reports.say(
                pou.file,
                source.tree.position,
                f"an instance of {pou.name} has {pou.type.size} bytes, with the blocks in it",
                f"at most {limit} bytes (PD-316)",
            )


# ---- PD-313, PD-315: everything together


def _totals(project: Project, sizes: Sizes) -> None:
    size = sum(sizes.variable(variable) for variable in project.globals.values())
    retained = sum(sizes.variable(variable) for variable in _retained(project))
    for what, used, limit, row in (
        ("all variables have", size, project.limits.variables, "PD-313"),
        ("the RETAIN variables have", retained, project.limits.retain, "PD-315"),
    ):
        if used > limit:
            largest = max(project.globals.values(), key=sizes.variable)
            project.reports.say(
                largest.file,
                largest.position,
                f"{what} {used} bytes",
                f"at most {limit} bytes ({row})",
                f"the largest is {largest.name}",
            )


def _retained(project: Project) -> list[Variable]:
    """RETAIN variables at fixed addresses: global ones, and those of programs."""
    programs = [pou for pou in project.sources if pou.kind is PouKind.PROGRAM]
    variables = [*project.globals.values(), *(variable for pou in programs for variable in pou.variables.values())]
    return [variable for variable in variables if variable.is_retain and variable.space is not Space.FRAME]


# ---- PD-317 and recursion


def _stack(project: Project, sizes: Sizes) -> None:
    limit = project.limits.stack
    for pou, source in project.sources.items():
        size = sizes.frame(pou)
        if size > limit:
            project.reports.say(
                pou.file,
                source.tree.position,
                f"the variables of {pou.name} on the stack have {size} bytes",
                f"at most {limit} bytes (PD-317)",
                "pass large arrays through VAR_IN_OUT",
            )


def _recursion(project: Project) -> None:
    """A POU that calls itself, also through others, is allowed but noted: it may run out of stack."""
    state: dict[Pou, int] = {}
    for root in project.calls:
        if root in state:
            continue
        path: list[tuple[Pou, list[Pou]]] = [(root, list(project.calls.get(root, {})))]
        state[root] = 1
        while path:
            pou, rest = path[-1]
            if not rest:
                state[pou] = 2
                path.pop()
                continue
            called = rest.pop()
            if state.get(called) == 1:
                position = project.calls[pou][called]
                project.reports.note(
                    pou.file,
                    position,
                    f"{called.name} calls itself",
                    "the stack holds few levels of recursion (PD-317)",
                )
            elif called not in state:
                state[called] = 1
                path.append((called, list(project.calls.get(called, {}))))
