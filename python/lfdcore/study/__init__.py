"""Simulated studies: courses, drivers, runs, metrics, statistics and reports (Sec. 3.5, 3.6, App. A.2)."""
