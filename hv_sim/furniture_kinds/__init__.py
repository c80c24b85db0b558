"""Kinds of furniture, by family."""
