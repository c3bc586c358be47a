"""The friction laws: one file a law, numbers and bounds beside formula."""
