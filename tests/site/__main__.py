"""`make docs` builds the site of the docs into build/docs, and `python -m tests.site FOLDER` into another folder."""

import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from doc_pages import ROOT
from tests.site import pages
from tests.site.render import render


def main(site: Path, source: Path) -> int:
    """Write the source and the site into their folders, and return the exit code."""
    for folder in (site, source):
        shutil.rmtree(folder, ignore_errors=True)
    pages.write(source)
    code = render(source, site)
    if code == 0:
        sys.stdout.write(f"the site is {site / 'index.html'}\n")
    return code


if __name__ == "__main__":
    chosen = Path(sys.argv[1]) if sys.argv[1:] else ROOT / "build" / "docs"
    sys.exit(main(chosen, chosen.with_name(f"{chosen.name}-source")))
