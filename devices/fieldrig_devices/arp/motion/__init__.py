"""The card's two axes: counters, profiles, position loops, and the electronic cam."""
