"""The pictures in docs/pictures are what the scenes draw; `make pictures` draws them again."""

import re
from typing import Final
from xml.etree import ElementTree

import pytest
from tests.pictures.album import FOLDER, pictures
from tests.pictures.states import ASCENT, SMALL_CHARACTER


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


PAGE: Final = 880
"""Width of a page, in pixels."""
STATE_MACHINES: Final = ("arp-states", "cia402-states", "max4-axis-states", "mc4-enable")
LABEL: Final = re.compile(r'<text x="([\d.]+)" y="([\d.]+)" text-anchor="middle" class="halo">([^<]*)<')
BOX: Final = re.compile(r'<rect class="device" x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="([\d.]+)"')


@pytest.mark.parametrize("name", STATE_MACHINES)
def test_labels_of_a_state_machine_are_read_at_the_width_of_a_page(name: str) -> None:
    """They had 6.6 px; a label that a box covers is not read either."""
    picture = (FOLDER / f"{name}.svg").read_text(encoding="utf-8")
    size, width = (re.search(pattern, picture) for pattern in (r'font-size="(\d+)"', r'viewBox="0 0 (\d+)'))
    assert size is not None
    assert width is not None
    assert int(size[1]) * PAGE / int(width[1]) >= 9
    labels, boxes = LABEL.findall(picture), [tuple(map(float, box)) for box in BOX.findall(picture)]
    assert labels
    assert boxes
    for x, y, text in labels:
        half = len(text) * SMALL_CHARACTER / 2
        for left, top, wide, high in boxes:
            is_beside = float(x) + half <= left or float(x) - half >= left + wide
            assert is_beside or float(y) <= top or float(y) - ASCENT >= top + high, text
