"""Laws of single summits by boundary elements on the pixels of their basins."""
