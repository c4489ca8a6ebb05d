"""`python -m common NAME [ARGUMENT …]` runs the bench of that name, as its script does."""

import sys
from importlib import import_module

from .bench import main

sys.exit(main(import_module(f"{sys.argv[1]}.bench").BENCH, sys.argv[2:]))
