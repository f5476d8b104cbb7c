"""What was logged: recordings, their turning points and loops, gaps, false values, ranges."""
