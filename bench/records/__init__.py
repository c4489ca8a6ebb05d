"""One idea per file; bench/README.md says what is measured."""
