"""Products on a belt: where they are, which sensors they cover, and how far the belt moves until that changes.

Positions count in m along the belt from its feed end.  A product is on the belt from its rear to its front.  A sensor
at `at` is covered while rear < at <= front.  A product leaves the belt when its rear reaches the discharge end, and is
lost when its front is back at the feed end.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import inf


@dataclass(slots=True)
class Product:
    number: int
    """Its place in the order in which all products were fed, from 1."""
    rear_m: float
    grip: float = 1.0
    """Its way for one of the belt; below 1 it slips."""


class Belt:
    """The belt and its products; `place_m` is the way that the belt has moved since the start."""

    def __init__(
        self,
        length_m: float,
        product_m: float,
        sensors: Sequence[float],
        pitch_m: float | None,
        grip: Callable[[int], float],
    ) -> None:
        """`pitch_m` is the way between two products of the feeder; `grip` is that of a product, by its number."""
        self.length_m, self.product_m, self.sensors, self._pitch_m, self._grip = (
            length_m, product_m, sensors, pitch_m, grip,
        )  # fmt: skip
        self.place_m = 0.0
        self.products: list[Product] = []
        """The products in the order in which they were fed."""
        self.fed = self.discharged = self.lost = self.refused = 0
        self._next_feed_m = inf if pitch_m is None else pitch_m

    def move_to(self, place_m: float) -> None:
        """Move the belt, with what the feeder does and what leaves the belt on the way."""
        self._carry(place_m - self.place_m)
        self.place_m = place_m
        while self._next_feed_m <= place_m:
            self.feed(place_m - self._next_feed_m)
            self._next_feed_m += self._pitch_m or inf

    def feed(self, way_m: float = 0.0) -> bool:
        """Put a product on the belt, `way_m` of the belt ago; False if another one is in its place."""
        if not self.has_room(way_m):
            self.refused += 1
            return False
        self.fed += 1
        grip = self._grip(self.fed)
        self.products.append(Product(self.fed, way_m * grip, grip))
        return True

    def has_room(self, way_m: float = 0.0) -> bool:
        """True if no product is where a new one would be."""
        return all(abs(product.rear_m - way_m) >= self.product_m for product in self.products)

    def grip_again(self) -> None:
        """Ask for the grip of every product."""
        for product in self.products:
            product.grip = self._grip(product.number)

    def is_covered(self, at_m: float) -> bool:
        return any(product.rear_m < at_m <= product.rear_m + self.product_m for product in self.products)

    def way_to_change(self, direction: int) -> float:
        """The way of the belt, from 0 up, in this direction until something may change; infinite if nothing does."""
        nearest = self._next_feed_m - self.place_m if direction > 0 else inf
        for product in self.products:
            if product.grip:
                nearest = min(nearest, self._way(product, direction) / product.grip)
        return max(nearest, 0.0)

    def _way(self, product: Product, direction: int) -> float:
        """The way of this product until it covers or frees a sensor, or leaves the belt."""
        return min((way for edge in self._edges(product) if (way := edge * direction) >= 0), default=inf)

    def _edges(self, product: Product) -> Iterator[float]:
        """Ways forward to each position at which something changes; they are negative for positions behind."""
        rear, front = product.rear_m, product.rear_m + self.product_m
        for at in self.sensors:
            yield at - rear
            yield at - front
        yield self.length_m - rear
        yield -front

    def _carry(self, way_m: float) -> None:
        kept: list[Product] = []
        for product in self.products:
            product.rear_m += way_m * product.grip
            if product.rear_m >= self.length_m:
                self.discharged += 1
            elif product.rear_m + self.product_m <= 0:
                self.lost += 1
            else:
                kept.append(product)
        self.products = kept
