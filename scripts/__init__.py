"""Commands that a user types: thin, parse, call one function, print what to look at next."""
