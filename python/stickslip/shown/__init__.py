"""What a person sees: figures and reports."""
