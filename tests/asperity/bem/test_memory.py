"""The memory estimate."""

from __future__ import annotations

import pytest
from strategies import rough

from asperity import HalfSpace, bem_curve, errors
from asperity.bem import memory

BODY = HalfSpace.from_modulus(1.0)


def test_memory_is_estimated_and_refused(monkeypatch):
    """A grid that will not fit is refused with its size; one that fits is not."""
    memory.require_memory((100, 100), "periodic")
    monkeypatch.setattr("surfaces.numerics.memory.available_bytes", lambda: 10_000)
    with pytest.raises(errors.InputError, match=r"grid of 20 x 24 points needs .* are available"):
        bem_curve(rough((20, 24)), BODY, pressures=[0.1])
    assert memory.estimated_bytes((10, 10), "free") > memory.estimated_bytes((10, 10), "periodic")
    assert not memory.fits((20, 24), "free", 1)
