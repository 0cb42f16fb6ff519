"""Commands: clrt on the command line."""
