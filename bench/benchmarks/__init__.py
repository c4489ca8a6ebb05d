"""Published problems beside the program's answers; bench/README.md says more."""
