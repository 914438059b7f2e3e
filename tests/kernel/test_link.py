"""What devices of one process share that are at the same bus."""

from typing import Any

from fieldrig.link import shared
from fieldrig.node import EventNode, Post
from fieldrig.testing import RecordedLink


class Table:
    """Something to share."""


def test_devices_of_a_process_share_what_belongs_to_their_bus() -> None:
    post = Post()
    one, other = EventNode("one", post=post), EventNode("other", post=post)
    table = shared(one.link("ring"), Table)
    assert shared(other.link("ring"), Table) is table
    assert shared(one.link("ring"), dict) == {}, "of another kind"
    assert shared(one.link("other ring"), Table) is not table
    assert shared(EventNode("elsewhere").link("ring"), Table) is not table


def test_link_that_knows_of_no_others_shares_nothing() -> None:
    link = RecordedLink[Any]()
    assert shared(link, Table) is not shared(link, Table)
