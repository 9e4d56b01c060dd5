"""The self-contained report of a comparison."""
