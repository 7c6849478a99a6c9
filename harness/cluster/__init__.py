"""Runs on a cluster: Dask carries groups of series to its workers, which run them as one machine does."""
