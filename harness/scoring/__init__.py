"""Exact states at the samples, and the errors of a solution against them."""
