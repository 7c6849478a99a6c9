"""Cases: rigid bodies: free, tops, rolling, in a resisting medium, machines."""
