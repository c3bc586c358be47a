"""Discovery for a block on a belt whose friction differs from event to event."""
