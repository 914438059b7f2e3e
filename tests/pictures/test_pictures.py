"""The pictures in docs/pictures are what the scenes draw; `make pictures` draws them again."""

from xml.etree import ElementTree

import pytest
from tests.pictures.album import FOLDER, pictures


@pytest.mark.long
@pytest.mark.parametrize("name", pictures())
def test_a_picture_is_what_its_scene_draws(name: str) -> None:
    drawn = pictures()[name]()
    assert drawn == (FOLDER / f"{name}.svg").read_text(encoding="utf-8"), "`make pictures` draws it again"
    title, about = (ElementTree.fromstring(drawn)[place] for place in (0, 1))
    assert title.text
    assert about.text


def test_every_picture_has_a_scene() -> None:
    assert {path.stem for path in FOLDER.glob("*.svg")} == pictures().keys()
