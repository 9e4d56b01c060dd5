"""Corrections of the microcontact model, one file each."""
