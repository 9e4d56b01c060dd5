"""Self-contained HTML pages with interactive figures; that of height maps."""

from .maps import section, write_page

__all__ = ["section", "write_page"]
