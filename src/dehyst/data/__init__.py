"""Recordings; their turning points, loops and gaps; outliers; the range that percentages refer to."""
