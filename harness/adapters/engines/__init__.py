"""Physics engines: a file or two for each, and the part that all share."""
