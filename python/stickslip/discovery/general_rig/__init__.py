"""Discovery on rigs of bodies and matrices: the search of `discovery.laboratory`, with effects at places."""
