"""A clone of the project as git makes one, with the files that are not committed yet."""

import shutil
import subprocess
from pathlib import Path

from doc_pages import ROOT

TRACKED = ("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard")


def copy_clone(folder: Path) -> None:
    """Copy every file of the project that git knows or would add."""
    files = subprocess.run(TRACKED, cwd=ROOT, capture_output=True, check=True).stdout.decode().split("\0")
    for name in filter(None, files):
        if (ROOT / name).exists():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
