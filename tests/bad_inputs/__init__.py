"""What is tried with bad input, a module an area; see ../bad_input.py."""
