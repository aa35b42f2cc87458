"""lfdcore study safety: hostile sticks, and chairs that are not as they should be; collisions per 100 km."""
