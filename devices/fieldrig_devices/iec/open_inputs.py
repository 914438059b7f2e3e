"""Inputs that a library's block needs and that the program leaves open: SoMachine finds them when it compiles."""

from collections.abc import Iterable, Iterator

from fieldrig_devices.iec import program as ir
from fieldrig_devices.iec.flow import Mentioned
from fieldrig_devices.iec.tree import Section
from fieldrig_devices.languages.mistakes import Mistake


def open_inputs(mentioned: Mentioned, required: Iterable[str]) -> Iterator[Mistake]:
    """Yield a mistake for each instance that is called, while no statement gives it one of the `required` inputs.

    Elements of arrays, and what a pointer refers to, are not judged.
    """
    wanted = {name.casefold() for name in required}
    given = {
        (_instance(place.of), place.variable.name.casefold())
        for _, place in mentioned.targets
        if isinstance(place, ir.Component) and place.variable is not None
    }
    seen = set[ir.Variable]()
    for call in mentioned.calls:
        variable = _instance(call.instance) if call.pou.is_native else None
        if variable is None or variable in seen:
            continue
        seen.add(variable)
        for pin in call.pou.variables.values():
            key = pin.name.casefold()
            if pin.section is Section.INPUT and key in wanted and (variable, key) not in given:
                what, at = f"{variable.name}.{pin.name} is open", variable.position
                yield Mistake(at.line, at.column, what, f"{pin.name} := ... in its call", file=variable.file)


def _instance(place: ir.Place) -> ir.Variable | None:
    return place.variable if isinstance(place, ir.Cell | ir.Component) else None
