"""Corrections of the model: one module for each switch of `asperity.parameters.Corrections`."""
