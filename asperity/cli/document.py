"""The JSON document of ``--json``: what is not a finite number is null."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def document(content: Mapping[str, Any]) -> str:
    """Text of one JSON document.

    Examples
    --------
    >>> import numpy as np
    >>> from asperity.cli.document import document
    >>> document({"load": np.array([1.0, np.nan]), "converged": np.True_})
    '{"load": [1.0, null], "converged": true}'
    """
    return json.dumps(_plain(content), allow_nan=False)


def _plain(value: Any) -> Any:
    """The value of mappings, lists, finite numbers, words and nulls."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)
