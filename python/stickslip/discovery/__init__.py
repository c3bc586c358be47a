"""Closing the loop: what the declared model lacks, found in the readings."""
