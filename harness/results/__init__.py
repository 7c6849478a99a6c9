"""Results on disk, their analysis, and the comparison of two runs."""
