"""``python -m asperity``: the command line."""

from __future__ import annotations

import sys

from asperity.cli.main import main

sys.exit(main())
