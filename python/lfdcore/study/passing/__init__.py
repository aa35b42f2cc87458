"""lfdcore study passing: a cursor passes over a rectangle, with and without its size known (Sec. 5.5)."""
