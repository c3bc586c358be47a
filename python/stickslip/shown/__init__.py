"""What a person sees: figures, reports, progress."""
