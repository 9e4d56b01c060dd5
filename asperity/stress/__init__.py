"""Stiff and extreme cases through every engine, each judged by something that is exact."""
