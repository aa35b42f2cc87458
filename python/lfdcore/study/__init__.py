"""Closed-loop studies: courses, simulated drivers, metrics and reports."""
