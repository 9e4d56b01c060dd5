"""Corrections of the laws of single contacts, one file each."""
