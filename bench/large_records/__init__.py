"""One idea per file; bench/README.md says what the commands measure."""
