"""lfdcore study backwards: the whole way in reverse, with a scanner that sees all around (Sec. 6.2.1)."""
