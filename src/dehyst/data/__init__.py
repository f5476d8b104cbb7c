"""Recordings, their turning points, loops and gaps, outliers, and the range that percentages refer to."""
