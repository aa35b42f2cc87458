"""Ch. 3: local intention, path primitives, compliance, and the path that they lead to."""
