"""A difference between two levels of a factor, as a judge found it, ready to be held against a claim."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pipeline.stats.factorial import Difference


@dataclass(frozen=True)
class Step(Difference):
    """In normalised score, as a judge found it.

    Attributes:
        narrow_low, narrow_high: the 90 % interval; ``None`` where it is not held against a margin.
    """

    narrow_low: float | None
    narrow_high: float | None

    def turned(self) -> Step:
        """The same, second level less first."""
        return replace(
            self,
            first_deg=self.second_deg,
            second_deg=self.first_deg,
            difference=-self.difference,
            low=-self.high,
            high=-self.low,
            narrow_low=None if self.narrow_high is None else -self.narrow_high,
            narrow_high=None if self.narrow_low is None else -self.narrow_low,
        )

    def below(self, margin: float) -> bool:
        """Whether the 90 % interval lies within ± ``margin``."""
        low, high = self.narrow_low, self.narrow_high
        return low is not None and high is not None and -margin <= low and high <= margin

    def beyond(self, margin: float) -> bool:
        """Whether the whole interval lies beyond ``margin``, on either side."""
        return self.low > margin or self.high < -margin
