"""What pages share: their skeleton, and figures that zoom and show values."""
