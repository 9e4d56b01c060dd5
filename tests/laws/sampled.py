"""Batches of sampled profiles with known functions, in the shape that the laws take."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np


def sampled(functions, edges, *, stretch=1.0, rays=16, nodes=17, curvature=None):
    """Profiles of ``f(r, phi)`` on rays stretched by the aspect `stretch` of the summit ellipse."""
    turn = 2 * np.pi * np.arange(rays) / rays
    root = np.sqrt(stretch)
    phi = np.mod(np.arctan2(root * np.sin(turn), np.cos(turn) / root), 2 * np.pi)
    weight = 2 * np.pi / rays / (np.cos(turn) ** 2 / stretch + np.sin(turn) ** 2 * stretch)
    t = np.linspace(0.0, 1.0, nodes)
    n = len(functions)
    edge = np.array([np.broadcast_to(e(phi) if callable(e) else e, phi.shape) for e in edges])
    r = np.where(t == 0, 1e-4, t) * edge[..., None]
    q = np.array([f(r[i], phi[:, None]) / r[i] ** 2 for i, f in enumerate(functions)])
    return SimpleNamespace(
        phi=np.tile(phi, (n, 1)),
        weight=np.tile(weight, (n, 1)),
        edge=edge,
        t=t,
        q=q,
        valid=np.ones(n, bool),
        curvature=np.ones((n, 2)) if curvature is None else np.asarray(curvature, float),
    )
