"""Plan, worker processes and trials of a run."""
