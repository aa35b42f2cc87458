"""lfdcore study driving: drivers x courses x assistants, and short tasks (Sec. 3.5-3.6; Tables 3.1-3.3, 4.1)."""
