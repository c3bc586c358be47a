"""What was measured: files, columns, channels, recordings, cases, and where a block sticks in them."""
