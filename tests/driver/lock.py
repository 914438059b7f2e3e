"""Writes the lock files, docker/requirements.lock and tests/requirements.lock, and THIRD-PARTY.md: `make lock`.

The first has what fieldrig runs with and what builds it, for the image and `make lab`; the second adds the tools of the
tests.  Both hold for every Python and system that fieldrig supports, with the hashes of all files of each package.
"""

import json
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path

RUN, ALL = Path("docker/requirements.lock"), Path("tests/requirements.lock")
LICENCES = Path("THIRD-PARTY.md")
BUILD = "hatchling>=1.25\neditables>=0.5\n"  # what pip takes to install a clone as editable
COMPILE = (
    *(sys.executable, "-m", "uv", "pip", "compile", "--quiet", "--universal", "--python-version", "3.11"),
    *("--generate-hashes", "--no-header", "--no-annotate", "--no-emit-index-url", "--upgrade", "pyproject.toml", "-"),
)
INTRODUCTION = """\
# Third-party packages

fieldrig and its image install these packages unchanged, and each brings its licence text in a folder of its own.
asyncua and python-can are under the LGPL. They are separate packages, so `pip install` can replace each of them by
another version. `make lock` writes this table from the metadata of the packages.

| package | version | licence | source |
|---|---|---|---|
"""
VENDORED = Path("page/fieldrig_page/static/vendor/lock.json")
IN_THE_PAGE = """
The page of a rig has files of these packages of npm, unchanged, beside their licence texts
(`page/fieldrig_page/static/vendor`).

| package | version | licence | source |
|---|---|---|---|
"""
# Where a package states no licence in its metadata, or a whole text instead of a name.
STATED_ELSEWHERE = {"eclipse-zenoh": "EPL-2.0 OR Apache-2.0"}
PROJECT_PAGES = ("homepage", "source", "source code", "repository", "github", "documentation")


def main() -> None:
    compile_lock(ALL, "--extra", "dev")
    compile_lock(RUN, "--constraint", str(ALL))
    LICENCES.write_text(
        "".join((INTRODUCTION, *rows(packages(RUN)), IN_THE_PAGE, *vendored(VENDORED))), encoding="utf-8"
    )


def compile_lock(target: Path, *options: str) -> None:
    subprocess.run([*COMPILE, *options, "--output-file", str(target)], input=BUILD, text=True, check=True)


def packages(lock: Path) -> dict[str, str]:
    """Return the versions in a lock file by the name of the package."""
    return dict(re.findall(r"^([\w.-]+)==([\w.!+]+)", lock.read_text(encoding="utf-8"), re.MULTILINE))


def rows(versions: dict[str, str]) -> Iterator[str]:
    for name, version in versions.items():
        try:
            about = metadata.metadata(name)
        except metadata.PackageNotFoundError:
            continue  # for another system or Python than this one
        yield f"| {name} | {version} | {licence(name, about)} | {page(about)} |\n"


def vendored(lock: Path) -> Iterator[str]:
    """Yield the rows of the packages of npm that a lock file beside their files names."""
    for package, about in json.loads(lock.read_text(encoding="utf-8")).items():
        name, _, version = package.rpartition("@")
        yield f"| {name} | {version} | {about['licence']} | {about['source']} |\n"


def licence(name: str, about: metadata.PackageMetadata) -> str:
    classifiers = [line.rpartition(" :: ")[2] for line in every(about, "Classifier") if "License ::" in line]
    candidates = [
        STATED_ELSEWHERE.get(name, ""),
        *every(about, "License-Expression"),
        ", ".join(classifiers),
        *every(about, "License"),
    ]
    return next(text for text in candidates if text and "\n" not in text)


def page(about: metadata.PackageMetadata) -> str:
    urls = (line.partition(",") for line in every(about, "Project-URL"))
    by_label = {label.strip().lower(): url.strip() for label, _, url in urls}
    known = [by_label[label] for label in PROJECT_PAGES if label in by_label]
    return next(iter([*known, *every(about, "Home-page")]), "")


def every(about: metadata.PackageMetadata, field: str) -> Sequence[str]:
    return about.get_all(field) or ()


if __name__ == "__main__":
    main()
