"""Runs cases through integrators, times, judges, stores and reports."""
