"""Input of a coupled solve: what cannot be used is refused in one sentence."""

from __future__ import annotations

import numpy as np
import pytest
from oracles import HertzTable

from asperity.errors import InputError
from asperity.halfspace.material import HalfSpace
from asperity.interaction.population import Population


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": np.zeros(3)}, "rows"),
        ({"height": np.full(5, np.nan)}, "height"),
        ({"boundary": "mirror"}, "boundary"),
        ({"cell": (1.0, -2.0)}, "cell"),
        ({"y": np.zeros((5, 1))}, "one-dimensional"),
        ({"cell": 3.0}, "cell"),
        ({"material": 3.0}, "HalfSpace"),
        ({"curvature": np.ones((3, 2)), "angle": np.zeros(5)}, "curvature"),
    ],
)
def test_unusable_input_is_refused(change, message):
    good = {
        "x": np.arange(5.0), "y": np.arange(5.0), "height": np.zeros(5),
        "table": HertzTable(np.ones(5), np.ones(5)), "cell": (5.0, 6.0),
        "boundary": "periodic", "material": HalfSpace.from_modulus(1.0),
    }  # fmt: skip
    with pytest.raises(InputError, match=message):
        Population(**{**good, **change})
