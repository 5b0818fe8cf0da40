"""The random numbers that Cycles makes of whole numbers."""

WORD = 0xFFFFFFFF


def hash_words(*words: int) -> int:
    """Bob Jenkins' lookup3 of one or two 32 bit words."""
    start = 0xDEADBEEF + (len(words) << 2) + 13
    x, y = (*words, 0)[:2]
    a, b, c = (start + x) & WORD, (start + y) & WORD, start & WORD
    for shift in (14, 11, 25, 16, 4, 14, 24):  # c, a and b change in turn, each by the one before
        c, a, b = a, b, ((c ^ b) - (b << shift | b >> (32 - shift))) & WORD
    return b
