"""Noise of sensors: a sample is a function of seed, time step and channel, and has no state.

Every number up to the last line is whole and below 2^53, so that doubles hold it exactly on any mathematics backend.
Two words of 25 bits, which count steps and channels, pass a Feistel network; its round function is the middle of a
square, as in Widynski's counter-based generator (arXiv:2004.06278), and its keys come from the seed. Box and Muller's
formula makes two independent normal numbers of the two words. The counter starts again after 2^25 steps.
"""
from math import pi

WORD, MIDDLE = 2.0**25, 2.0**12
MULTIPLIER, INCREMENT = 20738143.0, 11863285.0  # odd; the golden ratio's and the square root of 2's first bits
ROUNDS = 8  # with 4 the statistics are those of chance already, with 3 they are not
LARGEST_SEED = 2.0**31 - 2


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


def normal_pair(m, left, right):
    """Two independent normal numbers of two words."""
    radius = m.sqrt(-2.0 * m.log((left + 0.5) / WORD))
    angle = 2.0 * pi * ((right + 0.5) / WORD)
    return [radius * m.cos(angle), radius * m.sin(angle)]


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
