"""HTML from the source of the site, by Sphinx in a process of its own, as it changes what it finds in its process.

A warning, such as of a link or an anchor that leads nowhere, is an error.
"""

import subprocess
import sys
from pathlib import Path
from typing import Final

HERE: Final = Path(__file__).parent
STRICT: Final = ("--fail-on-warning", "--keep-going", "--quiet", "--fresh-env")


def render(source: Path, site: Path) -> int:
    """Write the site into its folder, and return the exit code of Sphinx, which writes what is wrong to stderr."""
    folders = ("--conf-dir", str(HERE), "--doctree-dir", str(source / ".doctrees"), str(source), str(site))
    return subprocess.run([sys.executable, "-m", "sphinx", *STRICT, *folders], check=False).returncode
