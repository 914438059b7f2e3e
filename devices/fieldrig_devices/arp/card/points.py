"""What `fieldrig get`, `set` and `watch` see of a card: its state, its axes, everything a program has a name for."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

from fieldrig.device import Point, Value
from fieldrig.point_values import choice_in, number_in, truth_in
from fieldrig_devices.arp.card.local_io import ANALOG_OUTPUTS, DIGITAL_INPUTS, INPUTS, UNITS, LocalIo
from fieldrig_devices.arp.card.permanent import COUNT
from fieldrig_devices.arp.card.settings import raw_value
from fieldrig_devices.arp.fixed import SCALE, to_raw
from fieldrig_devices.arp.language.instructions import WRITABLE, numbers
from fieldrig_devices.arp.outside import Outside
from fieldrig_devices.arp.parameters import PARAMETERS

GROUP_KEYS: Final = ("par", "par1", "par2")
COMMANDS: Final = ("run", "stop", "reset")


def points(card: Outside, io: LocalIo) -> dict[str, Point]:
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


def _states(card: Outside) -> Iterator[tuple[str, Point]]:
    def command(word: Value) -> None:
        choice_in(word, COMMANDS)
        if word == "reset":
            card.reset()
        elif not (card.run_program() if word == "run" else card.stop_program()):
            raise ValueError(f"that has no meaning in state {_state(card)}")

    yield "state", Point(partial(_state, card), command, "", "of the card; write run, stop or reset")
    yield "error", Point(lambda: card.errors.error, about="code of the last error, 103 to 116")
    yield "error_axis", Point(lambda: card.errors.error_axis, about="which axis the error is about")
    yield "warning", Point(lambda: card.errors.warning, about="code of the last warning, 201 to 204")
    yield "program", Point(lambda: card.program_name, about="its name")
    yield "program.state", Point(partial(_program_state, card))
    yield "program.line", Point(partial(_program_line, card), about="of the instruction that comes next")


def _state(card: Outside) -> str:
    return card.state.name.lower()


def _program_state(card: Outside) -> str:
    return "none" if card.program is None else card.program.state.name.lower()


def _program_line(card: Outside) -> int:
    return 0 if card.program is None else card.program.place.line


def _axes(card: Outside) -> Iterator[tuple[str, Point]]:
    for axis in (1, 2):
        yield f"axis{axis}.position", Point(partial(_scaled, card.position, axis), None, "unit", f"@POS{axis}")
        yield f"axis{axis}.speed", Point(partial(_scaled, card.speed, axis), None, "unit/s", f"#VEL{axis}")
        yield (
            f"axis{axis}.error",
            Point(partial(_scaled, card.tracking_error, axis), None, "unit", "reference - reading"),
        )


def _terminals(card: Outside, io: LocalIo) -> Iterator[tuple[str, Point]]:
    """Inputs can be written while no wire drives them."""
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


def _flag(card: Outside, number: int) -> Point:
    def write(value: Value) -> None:
        card.set_flag(number, int(truth_in(value)))

    return Point(partial(_bit, card.F, number), write if number in WRITABLE else None)


def _output(card: Outside, number: int) -> Point:
    def write(value: Value) -> None:
        if not card.set_output(number, int(truth_in(value))):
            raise ValueError(f"outputs are held at 0 in state {_state(card)}")

    return Point(partial(_bit, card.O, number), write)


def _variable(card: Outside, number: int) -> Point:
    def write(value: Value) -> None:
        card.set_variables(number, [to_raw(f"{number_in(value):.12g}")])

    return Point(lambda: card.V[number] / SCALE, write)


def _parameters(card: Outside) -> Iterator[tuple[str, Point]]:
    """What counts now: the copies in RAM."""
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
                ),
            )


def _parameter(card: Outside, group: int, number: int) -> float:
    return card.parameters.ram[group][number] / SCALE


def _set_parameter(card: Outside, group: int, number: int, value: Value) -> None:
    card.set_parameter(group, number, raw_value(group, number, number_in(value)))
