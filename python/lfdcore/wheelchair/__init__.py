"""The wheelchair: what is learned from demonstrations, and the assistants that use it."""
