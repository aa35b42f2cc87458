"""lfdcore study covering: a bag is pulled over furniture, with and without a look at the scene (Sec. 5.6)."""
