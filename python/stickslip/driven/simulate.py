"""Motion of a driven slider, under the name that scripts of version 0.1 import it by."""

from stickslip.simulated.driven_slider import Driven, Loop, Slider, closed_loop, forecast

__all__ = ["Driven", "Loop", "Slider", "closed_loop", "forecast"]
