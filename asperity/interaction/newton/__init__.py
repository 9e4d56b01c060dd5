"""The coupled problem of the contacts, and its solution by Newton steps."""
