"""Collaboration of a person and a static humanoid (Ch. 5): the scene, and what counts as done."""
