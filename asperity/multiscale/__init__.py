"""Waves too fine for contacts of their own: a law within the contacts of the longer waves."""
