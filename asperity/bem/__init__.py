"""Boundary-element solution of the full contact problem: the reference of the approximate models.

This package knows height maps, the elastic half-space and the containers of results, and nothing of
the model that it judges. That takes two things from here: the displacement by one pressed element
(`kernel`, tested against closed forms) and the labels of patches (`contact_map`).
"""

from __future__ import annotations
