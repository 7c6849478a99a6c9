"""Exact motions. Rigid bodies: free, tops, rolling, in a resisting medium, machines."""
