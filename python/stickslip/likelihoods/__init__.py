"""Likelihoods of a measurement: what the readings say where friction differs from event to event."""
