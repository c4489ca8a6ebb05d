"""`PYTHONPATH=bench python -m overview` writes what opens and closes docs/numbers.md."""

from .sections import put_overview

put_overview()
