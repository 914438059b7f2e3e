"""The command `fieldrig dial`: a caller for hosts without a PPP client of their own."""

from typing import TYPE_CHECKING, Annotated, Final

import typer

from fieldrig.cli.common import argument, duration_ns

if TYPE_CHECKING:
    from fieldrig_bus.serial.caller import Forward

PASSWORD_VARIABLE: Final = "FIELDRIG_DIAL_PASSWORD"
DEFAULT_FORWARD: Final = "8080:80"
LOCAL_HOST: Final = "127.0.0.1"


def dial(
    port: Annotated[
        str, argument("PORT", "The modem's line: a serial device, a pty, tcp://HOST:PORT or rfc2217://HOST:PORT.")
    ],
    number: Annotated[
        str | None, argument("NUMBER", "The number to dial; leave it out on a line without a modem.")
    ] = None,
    user: Annotated[str, typer.Option("--user", metavar="NAME", help="User name of the login by PAP.")] = "",
    password: Annotated[
        str,
        typer.Option("--password", metavar="TEXT", envvar=PASSWORD_VARIABLE, help="Password of the login by PAP."),
    ] = "",
    forward: Annotated[
        list[str] | None,
        typer.Option(
            "--forward",
            metavar="LOCAL:REMOTE",
            help=f"Lead a local port to a port of the controller, such as {DEFAULT_FORWARD}, which is the default. "
            "May be given several times.",
            show_default=False,
        ),
    ] = None,
    socks: Annotated[
        int | None,
        typer.Option(
            "--socks",
            metavar="LOCAL",
            min=1,
            max=65_535,
            help="Open a SOCKS 5 proxy at a local port, for programs that need several ports, such as FTP clients.",
            show_default=False,
        ),
    ] = None,
    init: Annotated[
        list[str] | None,
        typer.Option("--init", metavar="AT...", help="Commands for the modem before it dials.", show_default=False),
    ] = None,
    baud: Annotated[int, typer.Option("--baud", min=300, max=4_000_000, help="Bit rate of the line in bit/s.")] = 38400,
    timeout: Annotated[
        str, typer.Option("--timeout", metavar="DURATION", help="Longest time until the modems are connected.")
    ] = "60s",
) -> None:
    """Dial into a controller, and lead local ports to its services.

    \b
        fieldrig dial run/teleservice/serial/caller 4711 --user service --password secret --forward 8080:80
        fieldrig dial /dev/ttyUSB0 0,4711 --init "AT&F E0 V1 X4 &D2" --forward 5020:502 --forward 4840:4840

    It dials by AT commands, brings a PPP link up, and runs a TCP/IP stack of its own, so it needs no privileges.
    The local ports are on 127.0.0.1 only. Ctrl-C hangs up.
    """
    from secrets import randbits

    from fieldrig.errors import RefusedError
    from fieldrig_bus.serial.caller import call
    from fieldrig_devices.dial.caller import Caller, Plan
    from fieldrig_devices.dial.chat import DEFAULT_INIT
    from fieldrig_devices.ppp.settings import Login

    forwards = forwards_of(forward, socks)
    try:
        login = Login.of(user, password) if user or password else None
    except ValueError as cause:
        raise typer.BadParameter(str(cause)) from cause
    plan = Plan(number, DEFAULT_INIT if init is None else tuple(init), login, duration_ns(timeout))

    def report_ports() -> None:
        for lead in forwards:
            where = "every port" if lead.remote_port is None else f"port {lead.remote_port}"
            typer.echo(f"{lead.local} leads to {where} of the controller.")
        typer.echo("Ctrl-C hangs up.")

    session = call(
        port, baud, lambda transmit: Caller(plan, lambda: randbits(32), transmit, typer.echo), forwards, report_ports
    )
    assert isinstance(session, Caller)
    if session.failure is not None:
        raise RefusedError(session.failure.what, session.failure.remedy)
    typer.echo("The call has ended.")


def forwards_of(texts: list[str] | None, socks: int | None) -> "list[Forward]":
    """Return the ways of all options; the default only if there is none."""
    from fieldrig_bus.serial.caller import Forward

    proxy = [] if socks is None else [Forward(f"{LOCAL_HOST}:{socks}", None)]
    return [forward_of(text) for text in texts or ([] if proxy else [DEFAULT_FORWARD])] + proxy


def forward_of(text: str) -> "Forward":
    """Return the two ports of LOCAL:REMOTE.  typer.BadParameter, with an example, for anything else."""
    from fieldrig_bus.serial.caller import Forward

    local, _, remote = text.partition(":")
    if not all(number.isascii() and number.isdigit() and 1 <= int(number) <= 65_535 for number in (local, remote)):
        raise typer.BadParameter(
            f"{text!r} is not a pair of ports; expected LOCAL:REMOTE, each 1 to 65535, such as {DEFAULT_FORWARD}"
        )
    return Forward(f"{LOCAL_HOST}:{local}", int(remote))
