"""Methods that force variables of a program.  It is the forcing of the debugger, so each sees what the other forces."""

from collections.abc import Callable, Sequence
from typing import Final

from fieldrig_bus.opcua.message import NODE, VALUE, AnyValue, Argument, Kind, Status
from fieldrig_devices.opcua.methods import Method
from fieldrig_devices.opcua.symbols import SymbolsTree
from fieldrig_devices.opcua.tree import WrongArgumentsError

VARIABLE: Final = Argument("Variable", NODE, "A variable of the program. An array means all of its elements.")
FORCED_VALUE: Final = Argument("Value", VALUE, "The value to hold it at, with the type of the variable.")
RELEASED: Final = Argument(
    "Variable", NODE, "A variable, or an object with all variables below it. The null NodeId means all variables."
)
FORCED: Final = Argument("Variables", NODE, "The variables that are forced.", is_array=True)


def forcing(program: Callable[[], SymbolsTree | None]) -> dict[str, Method]:
    """Return the methods.  `program` gives the variables of the program that is loaded, or None."""

    def force(path: AnyValue, value: AnyValue) -> None:
        variables, path = program(), str(path)
        node = None if variables is None else variables.find(path)
        if variables is None or node is None:
            raise WrongArgumentsError(Status.NOT_SUPPORTED, Status.GOOD)  # a parameter of the device
        if node.kind is not Kind.VARIABLE or not node.is_writable:
            raise WrongArgumentsError(Status.NOT_WRITABLE, Status.GOOD)
        try:
            variables.check(path, value)
        except TypeError as cause:
            raise WrongArgumentsError(Status.GOOD, Status.TYPE_MISMATCH) from cause
        except ValueError as cause:
            raise WrongArgumentsError(Status.GOOD, Status.OUT_OF_RANGE) from cause
        variables.force(path, value)

    def release(path: AnyValue) -> None:
        variables = program()
        if variables is not None:
            variables.release(str(path))

    def forced() -> Sequence[AnyValue]:
        variables = program()
        return [[] if variables is None else list(variables.forced())]

    return {
        "force": Method("Hold a variable at a value.", force, (VARIABLE, FORCED_VALUE)),
        "release": Method("Release forced variables.", release, (RELEASED,)),
        "forced": Method("Return the variables that are forced.", forced, (), (FORCED,), is_writable=False),
    }
