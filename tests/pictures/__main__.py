"""Draw the pictures of the documentation: `make pictures`, or `python -m tests.pictures NAME...` for some of them."""

import sys

from tests.pictures.album import FOLDER, pictures


def main(names: list[str]) -> None:
    FOLDER.mkdir(exist_ok=True)
    for name, draw in pictures().items():
        if not names or name in names:
            (FOLDER / f"{name}.svg").write_text(draw(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
