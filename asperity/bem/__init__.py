"""Boundary-element solution of the full contact problem: the reference of the approximate models.

This package knows height maps, the elastic half-space and the containers of results, and nothing of
the model that it judges, which takes nothing from here either.
"""

from __future__ import annotations
