"""Processes, locks and memory of the machine."""
