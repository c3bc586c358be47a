"""The yardstick of the tests: the model once more in plain Python, slow and obviously right."""
