"""Objects of a node whose values live by themselves; each takes its value at the instant of the change."""

from collections.abc import Iterator, Mapping
from functools import partial

from fieldrig.clock import Clock
from fieldrig_devices.canopen.datatypes import Boolean, Integer, Real
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.service import Reset, Service
from fieldrig_devices.canopen.terminals import Terminal, Terminals
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.sources.living import Chance, Living, LivingValues, seed_from
from fieldrig_devices.sources.settings import SourceSettings
from fieldrig_devices.sources.shapes import Number, is_on


def living_variable(dictionary: Dictionary, key: str) -> Variable:
    """The variable of a key such as `2000:01`.  ValueError for one that is not there, or holds no number."""
    variable = dictionary.by_key(key)
    if not isinstance(variable.type, Boolean | Integer | Real):
        raise ValueError(f"{key} is {variable.type.name}; expected an object that holds a number")
    return variable


class LivingObjects(Service):
    """Begins at each reset of the node, as at power-on."""

    def __init__(
        self,
        clock: Clock,
        dictionary: Dictionary,
        sources: Mapping[str, SourceSettings],
        terminals: Terminals,
        random: Chance | None,
    ) -> None:
        seed = seed_from(random) if sources else ""
        self._values = LivingValues(clock, _living(dictionary, sources, terminals, seed))

    def reset(self, scope: Reset) -> None:
        if scope is Reset.NODE:
            self._values.start()
            self._values.follow()

    def stop(self) -> None:
        """Change nothing until the next reset: the node is switched off."""
        self._values.stop()


def _living(
    dictionary: Dictionary, sources: Mapping[str, SourceSettings], terminals: Terminals, seed: str
) -> Iterator[Living]:
    for key, source in sources.items():
        variable = living_variable(dictionary, key)
        yield Living(source.begin(seed + key), partial(_put, variable, terminals.get(variable, variable)))


def _put(variable: Variable, terminal: Terminal, value: Number) -> None:
    """Give an object its value; one beyond its range becomes the end of the range."""
    terminal.put(is_on(value) if isinstance(variable.type, Boolean) else variable.nearest(value))
