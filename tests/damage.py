"""Ways in which files get damaged."""

from __future__ import annotations


def flipped(content: bytes, bit: int) -> bytes:
    """The same bytes with one bit turned."""
    turned = bytearray(content)
    turned[bit // 8] ^= 1 << bit % 8
    return bytes(turned)
