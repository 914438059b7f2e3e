"""The documents of docs/programs/iec-import*.md are imported, and become what the page says."""

import pytest
from doc_pages import Block, blocks, page_named
from exchange_documents import unit_of

from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.imports import read_source

PAGES = [page_named("iec-import.md"), page_named("iec-import-examples.md")]
BLOCKS = [block for page in PAGES for block in blocks(page) if block.info]
PAIRS = list(zip(BLOCKS[::2], BLOCKS[1::2], strict=True))


@pytest.mark.parametrize(("document", "result"), PAIRS, ids=[document.info[-1] for document, _ in PAIRS])
def test_a_document_of_the_page_becomes_what_the_page_says(document: Block, result: Block) -> None:
    assert document.info[:2] == ("xml", "file")
    unit, mistakes = read_source(document.info[2], document.text, EDITION_3)
    if result.info == ("text", "messages"):
        assert "\n".join(map(str, mistakes)) == result.text.strip()
        return
    assert result.info == ("iecst", "becomes")
    assert mistakes == []
    assert unit.declarations == unit_of(result.text).declarations
