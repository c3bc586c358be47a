"""The driven slider under the names of version 0.1; what is in it lives in `stickslip.simulated.driven_slider`."""
