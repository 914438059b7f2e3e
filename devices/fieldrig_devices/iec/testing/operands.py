"""The values of the variables in the condition of an AssertTrue or AssertFalse that has failed.

They are read when it fails, so an assert that holds costs nothing; what a call in it has returned is not known then.
"""

from collections.abc import Iterator, Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.debugged_scopes import Scope
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.tcunit.reach import Item
from fieldrig_devices.iec.testing.assertions import paths
from fieldrig_devices.iec.testing.texts import value_text
from fieldrig_devices.iec.values import NoTargetError
from fieldrig_devices.languages.resumable import Activation

_ASSERTS: Final = frozenset({"asserttrue", "assertfalse"})
MOST: Final = 8
"""Variables that are shown."""


class Operands:
    def __init__(self, runtime: Runtime, items: Sequence[Item]) -> None:
        self._runtime, self._items = runtime, items
        self._known: dict[str, dict[int, tree.Expression]] = {}
        """The conditions by the lines of their asserts, by files."""

    def text(self, file: str, line: int, at: Activation) -> str:
        """Return the variables with their values, such as `, where level = 3`; an empty text if there are none."""
        condition = self._conditions(file).get(line)
        scope = self._scope(at) if condition is not None else None
        if condition is None or scope is None:
            return ""
        shown = [one for path in dict.fromkeys(paths(condition)) if (one := self._value(scope, path))]
        return f", where {' and '.join(shown[:MOST])}" if shown else ""

    def _conditions(self, file: str) -> dict[int, tree.Expression]:
        if file not in self._known:
            declared = [item.declaration for item in self._items if item.file == file]
            self._known[file] = dict(found for one in declared for found in _asserted(one))
        return self._known[file]

    def _scope(self, at: Activation) -> Scope | None:
        runtime = self._runtime
        program, lowered = runtime.compiled.program, runtime.compiled.code
        title = lowered.titles[runtime.code.names_of_routines[at.routine]]
        pou = program.pous.get(".".join(map(program.dialect.key, title.split("."))))
        return None if pou is None else Scope(runtime, pou, at.frame, at.base, "")

    def _value(self, scope: Scope, path: str) -> str:
        symbol = scope.find(path)
        if symbol is None or not symbol.is_value:
            return ""
        try:
            return f"{path} = {value_text(symbol.type, self._runtime.read(symbol))}"
        except (NoTargetError, ValueError):  # a reference to nothing
            return ""


def _asserted(declaration: tree.Declaration) -> Iterator[tuple[int, tree.Expression]]:
    """Yield the lines of the asserts in a declaration, each with its condition."""
    for call in (part for part in tree.walk(declaration) if isinstance(part, tree.Call)):
        name = getattr(call.called, "name", getattr(call.called, "text", ""))
        named = {one.name.casefold(): one.value for one in call.arguments if one.name}
        first = next((one.value for one in call.arguments if not one.name), None)
        condition = named.get("condition", first)
        if str(name).casefold() in _ASSERTS and condition is not None:
            yield call.position.line, condition
