"""Corrections of contact laws, a module each, named as the switch (`asperity.parameters`)."""
