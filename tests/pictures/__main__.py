"""Draw the pictures of the documentation: `make pictures`, or `python -m tests.pictures NAME...` for some of them."""

import sys
from pathlib import Path

from tests.pictures.album import FOLDER, pictures

from fieldrig.text.nearest import closest


def main(names: list[str]) -> None:
    FOLDER.mkdir(exist_ok=True)
    known = pictures()
    for name in names:
        if name not in known:
            sys.exit(f"there is no picture {name}; {closest(name, list(known))}")
    for name, draw in known.items():
        if not names or name in names:
            (FOLDER / f"{name}.svg").write_text(draw(), encoding="utf-8")


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
    main(sys.argv[1:])
