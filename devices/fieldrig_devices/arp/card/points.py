"""The points of a card for `fieldrig get`, `set` and `watch`: its state, its axes, and all that programs can name."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

from fieldrig.device import Point, Value
from fieldrig.points.checks import choice_in, number_in, truth_in
from fieldrig_devices.arp.card.local_io import ANALOG_OUTPUTS, DIGITAL_INPUTS, INPUTS, UNITS, LocalIo
from fieldrig_devices.arp.card.permanent import COUNT
from fieldrig_devices.arp.card.settings import raw_value
from fieldrig_devices.arp.card_access import CardAccess
from fieldrig_devices.arp.fixed import SCALE, to_raw
from fieldrig_devices.arp.language.instructions import WRITABLE, numbers
from fieldrig_devices.arp.parameters import PARAMETERS

GROUP_KEYS: Final = ("par", "par1", "par2")
COMMANDS: Final = ("run", "stop", "reset")


def points(card: CardAccess, io: LocalIo) -> dict[str, Point]:
    return {
        **dict(_states(card)),
        **dict(_axes(card)),
        **dict(_terminals(card, io)),
        **{f"F{number}": _flag(card, number) for number in range(1, 321)},
        **{f"I{number}": Point(partial(_bit, card.I, number)) for number in sorted(numbers("I")) if number > 108},
        **{f"O{number}": _output(card, number) for number in sorted(numbers("O"))},
        **{f"V{number}": _variable(card, number) for number in range(1, COUNT + 1)},
        **dict(_parameters(card)),
    }


def _states(card: CardAccess) -> Iterator[tuple[str, Point]]:
    def command(word: Value) -> None:
        choice_in(word, COMMANDS)
        if word == "reset":
            card.reset()
        elif not (card.run_program() if word == "run" else card.stop_program()):
            raise ValueError(f"{word} is not possible in state {_state(card)}")

    yield "state", Point(partial(_state, card), command, "", "state of the card; write run, stop or reset")
    yield "error", Point(lambda: card.errors.error, about="code of the last error, 103 to 116")
    yield "error_axis", Point(lambda: card.errors.error_axis, about="axis of the error; 0 if it belongs to no axis")
    yield "warning", Point(lambda: card.errors.warning, about="code of the last warning, 201 to 204")
    yield "program", Point(lambda: card.program_name, about="name of the program")
    yield "program.state", Point(partial(_program_state, card))
    yield (
        "program.loading",
        Point(lambda: 0 if card.loading is None else card.loading.percent, unit="%", about="compiled of a new program"),
    )
    yield "program.line", Point(partial(_program_line, card), about="source line of the next instruction")


def _state(card: CardAccess) -> str:
    return card.state.name.lower()


def _program_state(card: CardAccess) -> str:
    return "none" if card.program is None else card.program.state.name.lower()


def _program_line(card: CardAccess) -> int:
    return 0 if card.program is None else card.program.place.line


def _axes(card: CardAccess) -> Iterator[tuple[str, Point]]:
    for axis in (1, 2):
        yield f"axis{axis}.position", Point(partial(_scaled, card.position, axis), None, "unit", f"@POS{axis}")
        yield f"axis{axis}.speed", Point(partial(_scaled, card.speed, axis), None, "unit/s", f"#VEL{axis}")
        yield (
            f"axis{axis}.error",
            Point(partial(_scaled, card.tracking_error, axis), None, "unit", "tracking error, reference minus reading"),
        )


def _terminals(card: CardAccess, io: LocalIo) -> Iterator[tuple[str, Point]]:
    """Points of the terminals.  Inputs can be written while no wire drives them."""
    for terminal in INPUTS:
        about = "Enable" if terminal == "I108" else "" if terminal in DIGITAL_INPUTS else "at the terminals"
        yield (
            terminal,
            Point(partial(io.present, terminal), partial(_put, io, terminal), UNITS.get(terminal, ""), about),
        )
    for channel in range(1, 7):
        about = f"ADC {channel}, as the program reads it"
        yield f"adc{channel}.read", Point(partial(_scaled, card.analog_input, channel), None, "", about)
    for terminal, channel in ANALOG_OUTPUTS.items():
        yield terminal, Point(partial(_scaled, card.analog_output, channel), None, "V")


def _put(io: LocalIo, terminal: str, value: Value) -> None:
    io.put(terminal, truth_in(value) if terminal in DIGITAL_INPUTS else number_in(value))


def _scaled(read: Callable[[int], int], number: int) -> float:
    return read(number) / SCALE


def _bit(table: list[int], number: int) -> bool:
    return bool(table[number])


def _flag(card: CardAccess, number: int) -> Point:
    def write(value: Value) -> None:
        card.set_flag(number, int(truth_in(value)))

    return Point(partial(_bit, card.F, number), write if number in WRITABLE else None)


def _output(card: CardAccess, number: int) -> Point:
    def write(value: Value) -> None:
        if not card.set_output(number, int(truth_in(value))):
            raise ValueError(f"outputs are held at 0 in state {_state(card)}")

    return Point(partial(_bit, card.O, number), write)


def _variable(card: CardAccess, number: int) -> Point:
    def write(value: Value) -> None:
        card.set_variables(number, [to_raw(f"{number_in(value):.12g}")])

    return Point(lambda: card.V[number] / SCALE, write)


def _parameters(card: CardAccess) -> Iterator[tuple[str, Point]]:
    """Points of the parameters, which are the copies in RAM."""
    for group, key in enumerate(GROUP_KEYS):
        for number, parameter in PARAMETERS[group].items():
            unit = "" if parameter.unit == "code" else parameter.unit
            yield (
                f"{key}.{number}",
                Point(
                    partial(_parameter, card, group, number),
                    partial(_set_parameter, card, group, number),
                    unit,
                    parameter.name,
                    low=parameter.low / SCALE,
                    high=parameter.high / SCALE,
                ),
            )


def _parameter(card: CardAccess, group: int, number: int) -> float:
    return card.parameters.ram[group][number] / SCALE


def _set_parameter(card: CardAccess, group: int, number: int, value: Value) -> None:
    card.set_parameter(group, number, raw_value(group, number, number_in(value)))
