"""lfdcore study adaptation: a driver with a steering bias, and an assistant that learns it (Sec. 6.2.1)."""
