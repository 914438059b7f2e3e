"""`fieldrig nameplate`: electronic name plates, in encoders and in files."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldrig.cli.common import AsJson, assignment, command_group, echo_json, echo_table, port_option, writing

if TYPE_CHECKING:
    from fieldrig_devices.hiperface.plate import NamePlate
    from fieldrig_devices.hiperface.port import EncoderPort

app = command_group()

Port = Annotated[
    str | None,
    port_option("The encoder's line", "FIELDRIG_NAMEPLATE_PORT"),
]
Baud = Annotated[int, typer.Option("--baud", min=600, max=38400, help="Bit rate in bit/s.")]
Address = Annotated[
    str, typer.Option("--address", metavar="HEX", help="Address of the encoder; FF addresses any encoder.")
]
Code = Annotated[str, typer.Option("--code", metavar="HEX", help="Access code of the plate's data field.")]
PlateFile = Annotated[Path, typer.Argument(metavar="FILE", help="A plate file, YAML.", show_default=False)]


@app.callback()
def nameplate() -> None:
    """Read and write electronic name plates of motors.

    A name plate is in the encoder of a motor, or in a YAML file.

    \b
        fieldrig nameplate read --port run/lab/serial/encoder
        fieldrig nameplate write motor.yaml --port socket://127.0.0.1:7011
        fieldrig nameplate edit motor.yaml --set rated_current_a=4.2
    """


@app.command()
def show(file: PlateFile, as_json: AsJson = False) -> None:
    """Show all values of a plate file."""
    from fieldrig_devices.hiperface.plate_file import load_plate

    _echo(load_plate(file), {}, as_json)


@app.command()
def read(
    port: Port = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Write a plate file as well.", show_default=False)
    ] = None,
    address: Address = "40",
    code: Code = "55",
    baud: Baud = 9600,
    as_json: AsJson = False,
) -> None:
    """Read the plate of an encoder.

    \b
        fieldrig nameplate read --port /dev/ttyUSB0 --out motor.yaml
    """
    from fieldrig_devices.hiperface.client import read_identity, read_plate

    with _opened(port, address, baud) as encoder:
        identity = encoder.run(read_identity())
        plate = encoder.run(read_plate(_byte("--code", code)))
    if out is not None:
        _save(plate, out)
    about = {"encoder_type": f"{identity.type_code:02X}h", "encoder_serial_number": identity.serial_number}
    _echo(plate, about, as_json)


@app.command()
def write(file: PlateFile, port: Port = None, address: Address = "40", code: Code = "55", baud: Baud = 9600) -> None:
    """Write a plate file to an encoder, and verify it.

    A drive reads the plate at its next start.
    """
    from fieldrig_devices.hiperface.client import write_plate
    from fieldrig_devices.hiperface.plate_file import load_plate

    plate = load_plate(file)
    with _opened(port, address, baud) as encoder:
        encoder.run(write_plate(plate, _byte("--code", code)))
    typer.echo(f"{file}: {plate.type}, {plate.serial_number} is in the encoder")


@app.command()
def edit(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="[FILE]", help="A plate file; without it, the encoder at --port.", show_default=False),
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="New value of a key. May be given several times.", show_default=False
        ),
    ] = None,
    port: Port = None,
    address: Address = "40",
    code: Code = "55",
    baud: Baud = 9600,
) -> None:
    """Change values of a plate; an invalid plate is refused, and nothing is changed.

    \b
        fieldrig nameplate edit motor.yaml --set rated_current_a=4.2 --set serial_number=17-0004
        fieldrig nameplate edit --port /dev/ttyUSB0 --set offset_increments=12500
    """
    from fieldrig_devices.hiperface.client import read_plate, write_plate
    from fieldrig_devices.hiperface.plate_file import edited, load_plate

    new_values = _changes(changes or [])
    if file is not None:
        before = load_plate(file)
        after = edited(before, new_values)
        _save(after, file)
    else:
        with _opened(port, address, baud) as encoder:
            before = encoder.run(read_plate(_byte("--code", code)))
            after = edited(before, new_values)
            encoder.run(write_plate(after, _byte("--code", code)))
    for key in new_values:
        typer.echo(f"{key}: {getattr(before, key)} -> {getattr(after, key)}")


@contextmanager
def _opened(port: str | None, address: str, baud: int) -> Iterator["EncoderPort"]:
    """Open the encoder's line for a command."""
    from fieldrig_devices.hiperface.port import open_port

    if port is None:
        raise typer.BadParameter("no encoder is given; expected --port PORT or FIELDRIG_NAMEPLATE_PORT")
    opened = open_port(port, baud, _byte("--address", address))
    try:
        yield opened
    finally:
        opened.close()


def _byte(option: str, text: str) -> int:
    try:
        number = int(text.removeprefix("0x"), 16)
    except ValueError:
        number = -1
    if not 0 <= number <= 0xFF:
        raise typer.BadParameter(f"{option}: {text!r} is not a byte in hex, 00 to FF")
    return number


def _changes(words: list[str]) -> dict[str, str]:
    if not words:
        raise typer.BadParameter("no change is given; expected --set KEY=VALUE")
    return dict(assignment(word, "rated_current_a=4.2") for word in words)


def _save(plate: "NamePlate", file: Path) -> None:
    from fieldrig_devices.hiperface.plate_file import save_plate

    with writing(file):
        save_plate(plate, file)


def _echo(plate: "NamePlate", about: dict[str, Any], as_json: bool) -> None:
    values = about | plate.model_dump() | {"acceleration_time_ms": round(plate.acceleration_time_ms, 2)}
    if as_json:
        echo_json(values)
        return
    abouts = {key: field.description for key, field in type(plate).model_fields.items()}
    abouts["acceleration_time_ms"] = "to rated speed at peak torque without load"
    echo_table(("key", "value", ""), ((key, value, abouts.get(key, "")) for key, value in values.items()))
