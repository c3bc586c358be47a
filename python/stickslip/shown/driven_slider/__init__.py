"""The page and the figures of a driven slider."""
