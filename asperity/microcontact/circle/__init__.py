"""Laws about a circle: the published first-order solution, and harmonic by harmonic."""
