"""Boundary-element solution of the full contact problem: the judge of the approximate models.

This package shares no code with the model that it judges; it knows height maps, the elastic
half-space and the containers of results, nothing else.
"""

from __future__ import annotations
