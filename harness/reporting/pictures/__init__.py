"""Pictures of motions, of failures, of distributions and of a run, as commands and charts draw them."""
