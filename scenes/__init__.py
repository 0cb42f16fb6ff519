"""The scenes that come with clrt, each a TOML file with its picture beside it."""
