"""Discovery where friction scatters, belts wobble and constants are only nearly right."""
