"""What opens and closes docs/numbers.md: the numbers that matter, and where all were measured."""

from .sections import put_overview

__all__ = ["put_overview"]
