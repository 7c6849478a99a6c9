"""Results files, their analysis, and the comparison of two runs."""
