"""A model held to readings: fits through simulation, identification, comparison and forecasts."""
