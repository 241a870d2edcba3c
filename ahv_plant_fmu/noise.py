"""Noise of sensors: a sample is a function of seed, time step and channel, and has no state.

Every number up to the last functions is whole and below 2^53, so that doubles hold it exactly on any backend.
Two words of 25 bits, which count steps and channels, pass a Feistel network; its round function is the middle of a
square, as in Widynski's counter-based generator (arXiv:2004.06278), and its keys come from the seed. Box and Muller's
formula makes two independent normal numbers of the two words. The counter starts again after 2^25 steps.

Logarithm, cosine and sine are series here: those of C libraries and of Python differ in last bits.
"""
from math import factorial, log, pi

WORD, MIDDLE = 2.0**25, 2.0**12
MULTIPLIER, INCREMENT = 20738143.0, 11863285.0  # odd; the golden ratio's and the square root of 2's first bits
ROUNDS = 8  # with 4 the statistics are those of chance already, with 3 they are not
LARGEST_SEED = 2.0**31 - 2
LOGARITHM = [2.0 / (2 * n + 1) for n in range(18)]  # series in even powers; what is left out is below 1e-17
SINE = [(-1.0) ** n / factorial(2 * n + 1) for n in range(9)]
COSINE = [(-1.0) ** n / factorial(2 * n) for n in range(9)]


def low_word(m, value):
    """`value` modulo WORD."""
    return value - WORD * m.floor(value / WORD)


def keys(m, seed):
    """The key of every round, from a whole number."""
    key = low_word(m, MULTIPLIER * low_word(m, seed))
    return [key := low_word(m, key + INCREMENT) for _ in range(ROUNDS)]


def mixed(m, left, right, round_keys):
    """Two words made of two words, one to one."""
    for key in round_keys:
        total = right + key
        left, right = right, low_word(m, left + m.floor(total * total / MIDDLE))
    return left, right


def polynomial(coefficients, x):
    """The polynomial's value, with the constant first."""
    value = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        value = coefficient + x * value
    return value


def logarithm(m, x):
    """The natural logarithm of a number from 2^-31 to 1."""
    power = 0.0
    for halvings in (16, 8, 4, 2, 1):
        small = x < 2.0**-halvings
        power = m.where(small, power - halvings, power)
        x = m.where(small, x * 2.0**halvings, x)
    ratio = (x - 1.0) / (x + 1.0)
    return power * log(2.0) + ratio * polynomial(LOGARITHM, ratio * ratio)


def on_the_circle(m, turns):
    """Cosine and sine of a part of a full turn, 0 to 1."""
    quarters = m.floor(4.0 * turns + 0.5)
    angle = 2.0 * pi * (turns - quarters / 4.0)
    cosine, sine = polynomial(COSINE, angle * angle), angle * polynomial(SINE, angle * angle)
    halves = m.floor(quarters / 2.0)
    odd = quarters - 2.0 * halves > 0.5
    sign = 1.0 - 2.0 * (halves - 2.0 * m.floor(halves / 2.0))
    return sign * m.where(odd, -sine, cosine), sign * m.where(odd, cosine, sine)


def normal_pair(m, left, right):
    """Two independent normal numbers of two words."""
    radius = m.sqrt(-2.0 * logarithm(m, (left + 0.5) / WORD))
    cosine, sine = on_the_circle(m, (right + 0.5) / WORD)
    return [radius * cosine, radius * sine]


def samples(m, seed, step, channels):
    """`channels` independent normal numbers (mean 0, variance 1) of the time step `step`, a whole number.

    Of `seed`, from 0 to LARGEST_SEED, the whole part counts.
    """
    seed = m.floor(seed)
    pairs = (channels + 1) // 2
    first = pairs * m.floor(seed / WORD)  # the seed's bits beyond a word take other blocks
    round_keys = keys(m, seed)
    words = [mixed(m, low_word(m, step), first + pair, round_keys) for pair in range(pairs)]
    return [number for two in words for number in normal_pair(m, *two)][:channels]
