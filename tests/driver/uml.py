"""Run a command inside user-mode Linux, whose kernel has the CAN modules that this machine's kernel may lack.

    python -m tests.driver.uml --writable build/test -- .venv/bin/pytest tests/real -m vcan

Debian's package `user-mode-linux` is a Linux kernel as an ordinary program: no virtualisation, no root.  The command
sees every file of this machine; what it writes vanishes with the guest, except in the folders named writable.  Its
output is streamed, its exit code returned.  guest.sh is what happens inside.  On a processor with AMX the kernel needs
wide_registers.c, which is compiled for each run.

Left out on purpose: the network of this machine (the guest has a loopback of its own), and speed: a system call takes
50 us there, so it is a place for correctness, never for measuring.
"""

import argparse
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

PYTHON = (sys.executable, "-m", "tests.driver.uml")
KERNEL = "linux.uml"
MODULES = Path("/usr/lib/uml/modules")
SYSTEM_PATH = f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"
CAN_MODULES = ("can", "can-raw", "can-bcm", "can-gw", "vcan", "vxcan", "slcan")
VCAN0_UP = "ip link add dev vcan0 type vcan\nip link set vcan0 up\n"

# As timeout(1) says it, and the shell for what SIGINT ended; 125: it never came to run the command.
TIMED_OUT, INTERRUPTED, GUEST_FAILED = 124, 130, 125


@dataclass(frozen=True, slots=True)
class Guest:
    """The properties of the virtual machine."""

    memory: str = "1G"
    modules: tuple[str, ...] = CAN_MODULES
    setup: str = VCAN0_UP
    """Shell lines, run as root before the command; the first that fails ends the guest."""
    writable: tuple[Path, ...] = ()
    limit_s: float = 300


def is_there() -> bool:
    """The kernel, and what the guest needs of this machine's programs."""
    programs = (KERNEL, "modprobe", "ip", *(("gcc",) if has_wide_registers() else ()))
    return MODULES.is_dir() and all(shutil.which(name, path=SYSTEM_PATH) for name in programs)


def has_wide_registers() -> bool:
    """True if the processor has AMX, whose registers are wider than the guest's kernel expects."""
    return " amx_tile" in Path("/proc/cpuinfo").read_text(encoding="utf-8")


def run(command: Sequence[str], guest: Guest) -> int:
    """The command's exit code, or TIMED_OUT, INTERRUPTED, GUEST_FAILED."""
    with tempfile.TemporaryDirectory(prefix="fieldrig-uml-") as folder:
        job = Path(folder)
        # Inside, standard output is a terminal, whatever it is here.
        colours = {} if sys.stdout.isatty() else {"NO_COLOR": "1"}
        _write_job(job, command, guest, {**os.environ, **colours})
        with (job / "kernel.log").open("wb") as kernel_log:
            ended = _boot(job, guest, kernel_log.fileno())
        return ended if ended is not None else _result(job)


def command_script(command: Sequence[str], environment: Mapping[str, str], folder: Path) -> str:
    """A shell script that runs the command with this environment in this folder."""
    kept = {
        name: text for name, text in environment.items() if name.isidentifier() and name not in ("_", "PWD", "SHLVL")
    }
    exports = "".join(f"export {name}={shlex.quote(text)}\n" for name, text in kept.items())
    return f"{exports}cd {shlex.quote(str(folder))} || exit 126\nexec {shlex.join(command)}\n"


def _write_job(job: Path, command: Sequence[str], guest: Guest, environment: Mapping[str, str]) -> None:
    for folder in guest.writable:
        folder.mkdir(parents=True, exist_ok=True)
    (job / "command.sh").write_text(command_script(command, environment, Path.cwd()))
    (job / "modules").write_text(" ".join(guest.modules) + "\n")
    (job / "setup.sh").write_text(guest.setup)
    (job / "writable").write_text("".join(f"{folder.resolve()}\n" for folder in guest.writable))
    script = shutil.copy(Path(__file__).with_name("guest.sh"), job)
    Path(script).chmod(0o755)


def _preloaded(job: Path) -> dict[str, str]:
    """The environment variables for the kernel that make it run on this processor."""
    if not has_wide_registers():
        return {}
    source, library = Path(__file__).with_name("wide_registers.c"), job / "wide_registers.so"
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", str(library), str(source), "-ldl"], check=True)
    return {"LD_PRELOAD": str(library)}


def _boot(job: Path, guest: Guest, kernel_log: int) -> int | None:
    """Boot, and wait for the end; None if the guest came to it by itself."""
    kernel = [
        KERNEL,
        f"mem={guest.memory}",
        "root=/dev/root",
        "rootfstype=hostfs",
        "rootflags=/",
        "ro",
        "quiet",
        "panic=-1",
    ]
    job_options = [f"init={job}/guest.sh", f"job={job}", f"uml_dir={job}", "umid=guest"]
    consoles = ["con=null", f"con0=null,fd:{kernel_log}", "con1=fd:0,fd:1"]
    process = subprocess.Popen(
        # A kernel that outlives a killed test driver would hold the machine's memory.
        ["setpriv", "--pdeathsig", "KILL", *kernel, *job_options, *consoles],
        stdin=subprocess.DEVNULL,
        env={**os.environ, "HOME": str(job), **_preloaded(job)},
        pass_fds=(kernel_log,),
        start_new_session=True,
    )
    try:
        process.wait(guest.limit_s)
    except subprocess.TimeoutExpired:
        sys.stderr.write(f"uml: stopped after {guest.limit_s:g} s\n")
        return TIMED_OUT
    except KeyboardInterrupt:
        return INTERRUPTED
    finally:
        if process.poll() is None:
            # The whole group: the kernel has helper processes, which stay if only it is killed.
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    return None


def _result(job: Path) -> int:
    try:
        return int((job / "result").read_text())
    except (OSError, ValueError):
        log = (job / "kernel.log").read_text(errors="replace")
        sys.stderr.write(f"uml: the guest ended without a result; the end of its kernel log:\n{log[-3000:]}\n")
        return GUEST_FAILED


def _interrupt(_signal: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.driver.uml", description=(__doc__ or "").partition("\n")[0])
    usual = Guest()
    parser.add_argument("--memory", default=usual.memory)
    parser.add_argument("--modules", default=" ".join(usual.modules), help="kernel modules to load, in this order")
    parser.add_argument("--setup", default=usual.setup, help="shell lines to run before the command")
    parser.add_argument("--writable", type=Path, action="append", default=[], help="a folder whose changes stay")
    parser.add_argument("--seconds", type=float, default=usual.limit_s, help="time limit")
    parser.add_argument("command", nargs="+")
    asked = parser.parse_args()
    signal.signal(signal.SIGTERM, _interrupt)
    modules = tuple(asked.modules.split())
    return run(asked.command, Guest(asked.memory, modules, asked.setup, tuple(asked.writable), asked.seconds))


if __name__ == "__main__":
    sys.exit(main())
