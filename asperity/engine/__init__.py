"""The main door: choose boundary elements or the microcontact model, run, verify."""
