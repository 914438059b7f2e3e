"""The command `exec`: run a program of Python as a master, in the virtual time of a rig."""

import runpy
import sys
import time
import traceback
from pathlib import Path
from typing import Annotated, Final

import typer

from fieldrig.cli.common import Overrides, RigFile, argument
from fieldrig.errors import RigError, UsageError
from fieldrig.text.nearest import nearest_file

Program = Annotated[
    list[str], argument("-- PROGRAM.py ...", "The program with its arguments, or `-m MODULE` with them.")
]

_OURS: Final = frozenset((__file__, runpy.__file__, "<frozen runpy>"))
"""The files whose frames a traceback of the program begins with."""


def exec_(
    file: RigFile,
    program: Program,
    overrides: Overrides = None,
    jitter: Annotated[
        float, typer.Option(metavar="SECONDS", min=0, help="Wake the program late by up to this time, by chance.")
    ] = 0.0,
    seed: Annotated[int, typer.Option(help="Seed of this chance.")] = 0,
    limit: Annotated[float, typer.Option(metavar="SECONDS", min=0, help="Longest virtual time of the program.")] = 24
    * 3600.0,
    patience: Annotated[
        float, typer.Option(metavar="SECONDS", min=0, help="Longest real time that it may compute without waiting.")
    ] = 60.0,
) -> None:
    """Run a program of Python as a master, unchanged, in the virtual time of a rig.

    It connects to the addresses of the rig file, its waits take no real time, and each run gives the same bytes.  The
    rig file may be one of real time.

    \b
        fieldrig exec axes.yaml -- can_belt.py
        fieldrig exec axes.yaml --jitter 0.01 --seed 3 -- can_belt.py --speed 100
        fieldrig exec axes.yaml -- -m pytest test_belt.py
    """
    # Imported here: the other commands have no use for them, and a program of the user loads much.
    from fieldrig.config.rig_file import load
    from fieldrig.master_time.block import virtual_time
    from fieldrig.master_time.errors import VirtualTimeError
    from fieldrig.virtual.rig import Rig

    config = load(file, [*(overrides or ()), "time=virtual"])
    if program[0] != "-m" and not Path(program[0]).is_file():
        raise UsageError(f"there is no program {program[0]}", nearest_file(Path(program[0])))
    if program == ["-m"]:
        raise UsageError("-m without a module", "expected -m MODULE")
    began_s = time.monotonic()
    with Rig(config) as rig:
        try:
            with virtual_time(rig, jitter=jitter, seed=seed, limit_s=limit, patience_s=patience):
                _run(program)
        except VirtualTimeError as error:
            raise RigError(error.what, error.remedy) from error
        except RigError:
            raise
        except Exception as error:
            _show(error)
            raise SystemExit(1) from error
        finally:
            typer.echo(f"{rig.now_ns / 1e9:g} s of virtual time in {time.monotonic() - began_s:.2f} s", err=True)


def _show(error: Exception) -> None:
    """Print the traceback of the program, without our own frames and those of runpy, as Python would."""
    frames = error.__traceback__
    while frames is not None and frames.tb_frame.f_code.co_filename in _OURS:
        frames = frames.tb_next
    traceback.print_exception(type(error), error, frames)


def _run(program: list[str]) -> None:
    if program[0] == "-m":
        sys.argv = program[1:]
        sys.path.insert(0, "")
        runpy.run_module(program[1], run_name="__main__", alter_sys=True)
    else:
        sys.argv = program
        sys.path.insert(0, str(Path(program[0]).resolve().parent))
        runpy.run_path(program[0], run_name="__main__")
