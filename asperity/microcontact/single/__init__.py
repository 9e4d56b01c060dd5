"""One contact solved alone, by each law: `asperity.indent` and what stands behind it."""
