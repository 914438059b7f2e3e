"""Installs the packages of a lock file, then this clone, into the environment of this Python, and shows how far it is.

`make` calls it: `.venv/bin/python tests/driver/install.py docker/requirements.lock`.  It uses nothing but Python and
pip, as nothing else is there yet.
"""

import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input")
LOCKED = ("install", "--progress-bar=off", "--root-user-action=ignore", "--require-hashes", "--requirement")
# The lock file has the build tools as well, so that nothing is fetched without a hash.
THIS_CLONE = ("install", "--root-user-action=ignore", "--no-deps", "--no-build-isolation", "--editable", ".")
STEP = 10  # packages between two lines, where a line cannot be written over


class Progress:
    """One line that is written over on a terminal, and a line now and then elsewhere."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._seen = 0

    def take(self, line: str) -> None:
        """Take a line of pip's output."""
        if "(from -r " in line:  # pip names the line of the lock file, wherever it has the package from
            self._seen += 1
            if sys.stdout.isatty() or self._seen % STEP == 0:
                self._say(f"fetching package {self._seen} of {self._count}")
        elif line.startswith("Installing collected packages"):
            names = line.partition(":")[2].split(",")
            self._say(f"unpacking {f'{len(names)} packages' if len(names) > 1 else names[0].strip()}")

    def _say(self, text: str) -> None:
        sys.stdout.write(f"\r\x1b[K  {text}" if sys.stdout.isatty() else f"  {text}\n")
        sys.stdout.flush()


def main() -> int:
    lock = Path(sys.argv[1])
    count = sum("==" in line for line in lock.read_text(encoding="utf-8").splitlines())
    sys.stdout.write(
        f"installing fieldrig and {count} packages into .venv, which takes a minute or two the first time\n"
    )
    sys.stdout.flush()
    progress = Progress(count)
    is_done = run((*LOCKED, str(lock)), progress.take) and run(THIS_CLONE, progress.take)
    if sys.stdout.isatty():
        sys.stdout.write("\r\x1b[K")
    return 0 if is_done else 1


def run(arguments: Sequence[str], show: Callable[[str], None]) -> bool:
    """Run pip, and pass each line of its output to `show`; at a failure print the whole output."""
    lines = []
    with subprocess.Popen((*PIP, *arguments), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as pip:
        assert pip.stdout is not None
        for line in pip.stdout:
            lines.append(line)
            show(line)
    if pip.returncode != 0:
        sys.stdout.write(f"\n{''.join(lines)}")
        sys.stdout.write(
            "pip could not install fieldrig; its reason is above. It keeps what it has, so run make again.\n"
        )
    return pip.returncode == 0


if __name__ == "__main__":
    sys.exit(main())
