"""lfdcore study learning-curve: how much demonstration is enough (Sec. 6.2.1)."""
