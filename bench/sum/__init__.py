"""Modes and their sum beside numpy + FINUFFT in one process; bench/README.md says more."""
