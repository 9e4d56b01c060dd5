"""Exit codes of the commands."""

EXIT_OK, EXIT_NOT_CONVERGED, EXIT_BAD_INPUT = 0, 1, 2
EXIT_INTERRUPTED = 130
