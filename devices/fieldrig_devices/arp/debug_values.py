"""The values of a card for the debugging service: by the names of the program and its EQUs, and forced terminals.

A digital input is forced between its sampling and the program, a digital output between the program and its terminal.
Everything else is written by the program itself, in the middle of a slice, so the card could not hold it.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

from fieldrig.device import Value
from fieldrig_devices.arp import watch
from fieldrig_devices.arp.card_access import CardAccess, CardState
from fieldrig_devices.arp.fixed import SCALE, to_raw
from fieldrig_devices.arp.user_port import quantities
from fieldrig_devices.arp.user_port.messages import Quantity
from fieldrig_devices.arp.user_port.quantities import BITS, GROUPS, NUMBERS, WORDS, Kind
from fieldrig_devices.languages.debugging.debuggee import Variable

EQUS: Final = "EQU"
FORCED_INPUTS: Final = range(101, 108)
FORCED_OUTPUTS: Final = range(101, 105)
_GROUPS: Final = {
    "V": (Kind.VARIABLE,),
    "F": (Kind.FLAG,),
    "I": (Kind.INPUT,),
    "O": (Kind.OUTPUT,),
    "AXES": (Kind.POSITION, Kind.SPEED, Kind.TRACKING_ERROR),
    "ANALOG": (Kind.ANALOG_INPUT, Kind.ANALOG_OUTPUT),
    "PAR": (Kind.GENERAL_PARAMETER,),
    "PAR1": (Kind.PARAMETER_1,),
    "PAR2": (Kind.PARAMETER_2,),
    "CARD": (Kind.CONDITION,),
}
"""Groups of values as a tree has them, by their names."""


class CardValues:
    """The values of one card; `equs` returns the meanings of the names in its source."""

    def __init__(self, card: CardAccess, equs: Callable[[], Mapping[str, str]]) -> None:
        self._card, self._equs = card, equs
        self._forced: dict[Quantity, int] = {}

    # ---- reading

    def variables(self, path: str) -> Sequence[Variable]:
        if not path:
            names = [*([EQUS] if self._equs() else []), *_GROUPS]
            return [Variable(name, name, "group") for name in names]
        if path == EQUS and self._equs():
            return [self.evaluate(name) for name in self._equs()]
        if path.startswith("@"):
            return []  # a routine of a card has no variables of its own
        if path not in _GROUPS:
            raise ValueError(f"{path} is not a group of values: expected {', '.join(_GROUPS)}")
        kinds = _GROUPS[path]
        return [self._variable(Quantity(kind, number)) for kind in kinds for number in sorted(NUMBERS[kind])]

    def evaluate(self, text: str) -> Variable:
        """Return a value by its name, or that of an expression or condition."""
        if text in _GROUPS or (text == EQUS and self._equs()):
            return Variable(text, text, "group")
        try:
            quantity = self._named(text)
        except ValueError:
            value = watch.evaluate(text, self._read)
            if isinstance(value, bool):
                return Variable(text, text, "condition", value)
            return Variable(text, text, "number", value // SCALE if value % SCALE == 0 else value / SCALE)
        return self._variable(quantity, text.strip().upper())

    def _named(self, name: str) -> Quantity:
        """The value that a name means.  ValueError for a name without one, also if EQU defines it as a constant."""
        return quantities.named(self._equs().get(name.strip().upper(), name))

    def _read(self, name: str) -> int:
        meaning = self._equs().get(name.upper(), name)
        if name.upper() in self._equs() and meaning.lstrip("-").replace(".", "", 1).isdigit():
            return to_raw(meaning)
        quantity = quantities.named(meaning)
        raw = quantities.reader(self._card, quantity)()
        return raw * SCALE if quantity.kind in BITS or quantity.kind == Kind.CONDITION else raw

    def _variable(self, quantity: Quantity, name: str = "") -> Variable:
        own = quantities.name_of(quantity)
        raw = quantities.reader(self._card, quantity)()
        value_type = "bit" if quantity.kind in BITS else "bits" if quantity.kind in WORDS else "number"
        about = own if name and name.lstrip("@#") != own.lstrip("@#") else ""
        value = quantities.value_of(quantity, raw)
        return Variable(
            name or own, name or own, value_type, value, _is_writable(quantity), quantity in self._forced, about
        )

    # ---- writing

    def write(self, path: str, value: Value) -> None:
        quantity = self._named(path)
        raw = quantities.raw_of(quantity, _text(value))
        card, kind, number = self._card, quantity.kind, quantity.number
        if kind == Kind.VARIABLE:
            is_done = card.set_variables(number, [raw])
        elif kind == Kind.FLAG:
            is_done = card.set_flag(number, raw)
        elif kind == Kind.OUTPUT:
            is_done = card.set_output(number, raw)
        elif kind in GROUPS:
            is_done = card.set_parameter(GROUPS[Kind(kind)], number, raw)
        else:
            is_done = False
        if not is_done:
            state = f" in state {card.state.name}" if kind == Kind.OUTPUT else ""
            raise ValueError(f"{path} cannot be written{state}: expected a variable, a flag, an output or a parameter")

    # ---- forcing

    def force(self, path: str, value: Value | None) -> None:
        quantity = self._named(path)
        if value is None:
            self._forced.pop(quantity, None)
            return
        if not _can_be_forced(quantity):
            raise ValueError(f"{path} cannot be forced: {_why_not(quantity)}\nexpected I101 to I107 or O101 to O104")
        self._forced[quantity] = quantities.raw_of(quantity, _text(value))

    def forced(self) -> Sequence[Variable]:
        return [self._variable(quantity) for quantity in self._forced]

    def force_inputs(self) -> None:
        """Replace forced inputs; call it after they are sampled, before the program runs."""
        for (kind, number), bit in self._forced.items():
            if kind == Kind.INPUT:
                self._card.I[number] = bit

    def force_outputs(self) -> None:
        """Replace forced outputs; call it after the program, before the terminals.  Held outputs stay at 0."""
        if self._card.state not in (CardState.RUN, CardState.STOPPED):
            return
        for (kind, number), bit in self._forced.items():
            if kind == Kind.OUTPUT:
                self._card.O[number] = bit


def _is_writable(quantity: Quantity) -> bool:
    return quantity.kind in (Kind.VARIABLE, Kind.FLAG, Kind.OUTPUT) or quantity.kind in GROUPS


def _can_be_forced(quantity: Quantity) -> bool:
    kind, number = quantity
    return (kind == Kind.INPUT and number in FORCED_INPUTS) or (kind == Kind.OUTPUT and number in FORCED_OUTPUTS)


def _why_not(quantity: Quantity) -> str:
    match quantity:
        case (Kind.INPUT, 108):
            return "I108 is Enable, which the card itself obeys"
        case (Kind.INPUT | Kind.OUTPUT, _):
            return "it belongs to a node on CAN, and changes while the program runs"
        case (Kind.VARIABLE | Kind.FLAG, _):
            return "the program writes it in the middle of a control loop, where the card cannot hold it"
    return "the card measures or sets it by itself"


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return "1" if value else "0"
    return value if isinstance(value, str) else f"{value:.12g}"
