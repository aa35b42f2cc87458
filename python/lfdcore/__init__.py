"""lfdcore: assistive robots that learn from a few demonstrations."""

__version__ = "0.1.0"
