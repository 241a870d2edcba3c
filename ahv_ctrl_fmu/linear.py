"""Exact steps of small linear systems: the matrix exponential, on any mathematics backend."""
from operator import mul

SQUARINGS = 10
TERMS = 14


def product(a, b):
    """a @ b of two matrices (lists of rows)."""
    columns = list(zip(*b))
    return [[sum(map(mul, row, column)) for column in columns] for row in a]


def exponential(a):
    """exp(a) of a small square matrix (a list of rows) by scaling, Taylor series and squaring.

    The number of operations is fixed, so that it can be traced; with the 1-norm of `a` below 1000 the
    truncation error is below 1e-12 of the result, and rounding is what remains.
    """
    n = len(a)
    scaled = [[entry / 2**SQUARINGS for entry in row] for row in a]
    result = [[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)]
    for k in range(TERMS, 0, -1):  # Horner: I + A/1 (I + A/2 (I + ...))
        result = [[entry / k + (1.0 if i == j else 0.0) for j, entry in enumerate(row)]
                  for i, row in enumerate(product(scaled, result))]
    for _ in range(SQUARINGS):
        result = product(result, result)
    return result


def apply(matrix, vector):
    """matrix @ vector, with the matrix as a flat row-major sequence."""
    n = len(vector)
    return [sum(map(mul, matrix[i:i + n], vector)) for i in range(0, n * n, n)]
