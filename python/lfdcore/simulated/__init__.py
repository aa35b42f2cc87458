"""Stand-ins for people and places: courses, drivers, runs and their traces, partners and demonstrators."""
