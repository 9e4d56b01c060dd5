"""`asperity.solve`: choose boundary elements or the microcontact model, run, verify."""
