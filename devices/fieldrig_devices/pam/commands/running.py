"""The command `fieldrig pam run`: an application alone, with its variables on the screen."""

from typing import Final

import typer

from fieldrig.cli.common import AsJson, For, duration_ns
from fieldrig_devices.languages.debugging.alone import Settings, Speed, Watched, run_and_show, set_all
from fieldrig_devices.pam.commands.checking import File, IgnoresCase, compiled

NO_NODES: Final = "No node is behind the objects: inputs have the values of --set, and axes are ready at once."


def run(
    file: File,
    length: For = None,
    speed: Speed = 1.0,
    watched: Watched = None,
    settings: Settings = None,
    as_json: AsJson = False,
    ignores_case: IgnoresCase = False,
) -> None:
    """Run an application alone, without nodes, and show its variables, inputs and outputs.

    \b
        fieldrig pam run packer.pam
        fieldrig pam run packer.pam --set SBI_Start=true --watch IWV_Count
        fieldrig pam run packer.pam --for 10s --json

    No node is behind the objects: --set gives inputs their values, outputs and orders go nowhere, and every motion is
    ready at once. Values are set just after power-on, so that
    a flag that becomes true is an event. The exit code is 2 if the
    application has mistakes, and 6 if a fatal error has stopped it.
    """
    from fieldrig_devices.pam.runtime.solo import Solo

    limit_ns = None if length is None else duration_ns(length)
    solo = Solo(compiled(file, ignores_case=ignores_case))
    set_all(solo, settings or [])
    typer.echo(NO_NODES, err=True)
    solo.start()
    run_and_show(solo, watched or [], speed, limit_ns, as_json=as_json, is_failed=lambda: solo.is_over)
