"""The ST1: a digital servo with one axis and I/O boards, a node on the ring of a PAM."""
