"""Kinds of movable objects, by family."""
