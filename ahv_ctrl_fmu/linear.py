"""Exact steps of small linear systems: the matrix exponential, on any mathematics backend."""
from operator import mul

HALVINGS = 14  # at most: enough for a norm of 16384
TERMS = 18  # truncated at 1/19!, where the norm is 1


def product(a, b):
    """a @ b of two matrices (lists of rows)."""
    columns = list(zip(*b))
    return [[sum(map(mul, row, column)) for column in columns] for row in a]


def exponential(m, a):
    """exp(a) of a small square matrix (a list of rows) by scaling, Taylor series and squaring.

    Right to 1e-12 of its largest entry, or of 1 where all are smaller, for a 1-norm of `a` up to 2^HALVINGS. The
    number of operations is fixed, so that it can be traced, but only as many squarings are taken as the norm needs,
    since each doubles the rounding.
    """
    n = len(a)
    norm, scale, halved = 0.0, 1.0, []
    for column in zip(*a):
        norm = m.fmax(norm, sum(m.fabs(entry) for entry in column))
    for _ in range(HALVINGS):
        large = norm * scale > 1.0
        scale = m.where(large, 0.5 * scale, scale)
        halved.append(large)
    scaled = [[entry * scale for entry in row] for row in a]
    result = [[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)]
    for k in range(TERMS, 0, -1):  # Horner: I + A/1 (I + A/2 (I + ...))
        result = [[entry / k + (1.0 if i == j else 0.0) for j, entry in enumerate(row)]
                  for i, row in enumerate(product(scaled, result))]
    for large in halved:
        squared = product(result, result)
        result = [[m.where(large, new, old) for new, old in zip(*rows)] for rows in zip(squared, result)]
    return result


def apply(matrix, vector):
    """matrix @ vector, with the matrix as a flat row-major sequence."""
    n = len(vector)
    return [sum(map(mul, matrix[i:i + n], vector)) for i in range(0, n * n, n)]
