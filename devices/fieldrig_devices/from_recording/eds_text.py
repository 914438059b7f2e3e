"""The EDS of a node as a recording shows it."""

from fieldrig_devices.cia402.eds_file import Table, write
from fieldrig_devices.cia402.node_objects import NodeFacts, head
from fieldrig_devices.from_recording.described_node import DescribedNode

CREATED = "01-01-2026"
"""The date of the file: the same recording gives the same file."""
MOST_TEXT = 200


def eds_of(node: DescribedNode, file: str, source: str) -> str:
    """Return the text of the file for the node of a recording with the name `source`."""
    indices = {index for index, _ in node.rows}
    facts = NodeFacts(
        file=file,
        description=_line(f"Node {node.node_id} as the recording {source} shows it"),
        created=CREATED,
        vendor="unknown",
        product=_line(_text(node, 0x1008) or f"node {node.node_id}"),
        product_code=_number(node, 2),
        received_pdos=sum(0x1400 <= index < 0x1600 for index in indices),
        transmitted_pdos=sum(0x1800 <= index < 0x1A00 for index in indices),
        comments=(
            "Made from a recording: it has the objects that were read, written or sent, and says nothing of others.",
            "Types of objects that no standard defines are guessed from their sizes, and access from what was done.",
        ),
        vendor_number=_number(node, 1),
        revision=_number(node, 3),
    )
    return write(head(facts), [Table(list(node.listed()), node.names_of_all())])


def _number(node: DescribedNode, subindex: int) -> int:
    row = node.rows.get((0x1018, subindex))
    return row.start if row is not None and isinstance(row.start, int) else 0


def _text(node: DescribedNode, index: int) -> str:
    row = node.rows.get((index, 0))
    return row.start if row is not None and isinstance(row.start, str) else ""


def _line(text: str) -> str:
    """Return a text that fits on a line of an EDS."""
    plain = "".join(character if character.isascii() and character.isprintable() else "?" for character in text)
    return plain.replace(";", ",")[:MOST_TEXT].strip()
