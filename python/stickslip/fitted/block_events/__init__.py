"""A block on a belt event by event: each slip with a friction level of its own."""
