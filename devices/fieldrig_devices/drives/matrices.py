"""Matrices as lists of rows: the few operations that the model of an axis needs."""

Row = list[float]
Matrix = list[Row]


def product(a: Matrix, b: Matrix) -> Matrix:
    columns = list(zip(*b, strict=True))
    return [[sum(x * y for x, y in zip(row, column, strict=True)) for column in columns] for row in a]


def identity(size: int) -> Matrix:
    return [[float(i == j) for j in range(size)] for i in range(size)]


def exponential(a: Matrix) -> Matrix:
    """Return the matrix exponential, by scaling, Taylor's series and squaring."""
    largest = max(sum(map(abs, row)) for row in a)
    halvings = 0
    while largest > 0.25:
        largest, halvings = largest / 2, halvings + 1
    scaled = [[x / 2**halvings for x in row] for row in a]
    total, term = identity(len(a)), identity(len(a))
    for order in range(1, 14):
        term = [[x / order for x in row] for row in product(term, scaled)]
        total = [[x + y for x, y in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)]
    for _ in range(halvings):
        total = product(total, total)
    return total
