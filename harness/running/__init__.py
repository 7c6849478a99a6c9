"""Plan, processes and trials of a run."""
