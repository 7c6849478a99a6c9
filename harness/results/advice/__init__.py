"""Recommendations of methods for a need, from the measurements of a run or from the published table."""
