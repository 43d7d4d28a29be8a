"""Tokens: the numbers by which events answer commands."""

import numpy as np
import numpy.typing as npt

TokenArray = npt.NDArray[np.uint64]


class Tokens:
    """The tokens of a participant, and its number as a sender."""

    def __init__(self, name: str) -> None:
        self.sender = _fnv1a(name.encode())
        self._taken = 0

    def next(self) -> int:
        """Returns the next token."""
        self._taken += 1
        return ((self.sender << 32) + self._taken) & (2**64 - 1)

    def take(self, count: int) -> TokenArray:
        """Returns the next tokens, ``count`` of them."""
        before = self._taken
        self._taken += count
        high = np.uint64((self.sender << 32) & (2**64 - 1))
        return high + np.arange(before + 1, self._taken + 1, dtype=np.uint64)


def _fnv1a(text: bytes) -> int:
    """Returns the 64-bit FNV-1a hash of a text: the same name gives the same tokens in every run."""
    value = 0xCBF2_9CE4_8422_2325
    for byte in text:
        value = ((value ^ byte) * 0x0000_0100_0000_01B3) & (2**64 - 1)
    return value
