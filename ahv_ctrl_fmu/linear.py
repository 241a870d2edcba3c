"""Exact steps of small linear systems: the matrix exponential, on any mathematics backend."""
from operator import mul

SQUARINGS = 14
TERMS = 18  # truncated at 1/19!, where the scaled norm is 1


def product(a, b):
    """a @ b of two matrices (lists of rows)."""
    columns = list(zip(*b))
    return [[sum(map(mul, row, column)) for column in columns] for row in a]


def plus(a, number):
    """a + number I of a square matrix (a list of rows)."""
    return [[entry + number if i == j else entry for j, entry in enumerate(row)] for i, row in enumerate(a)]


def exponential(a):
    """exp(a) of a small square matrix (a list of rows) by scaling, Taylor series and squaring.

    Right to 1e-12 of its largest entry, or of 1 where all are smaller, for a 1-norm of `a` up to 2^SQUARINGS. The
    number of operations is fixed, so that it can be traced. What is squared is d = exp(...) - I, by
    (I + d)^2 - I = d (d + 2 I): in I + d a small d would be rounded, and each squaring would double that.
    """
    scaled = [[entry / 2**SQUARINGS for entry in row] for row in a]
    series = plus([[0.0] * len(a) for _ in a], 1.0)
    for k in range(TERMS, 1, -1):  # Horner: I + A/2 (I + A/3 (I + ...))
        series = plus([[entry / k for entry in row] for row in product(scaled, series)], 1.0)
    d = product(scaled, series)
    for _ in range(SQUARINGS):
        d = product(d, plus(d, 2.0))
    return plus(d, 1.0)


def apply(matrix, vector):
    """matrix @ vector, with the matrix as a flat row-major sequence."""
    n = len(vector)
    return [sum(map(mul, matrix[i:i + n], vector)) for i in range(0, n * n, n)]
