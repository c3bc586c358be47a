"""The page of `stickslip explore`: sliders, and curves that the core draws anew."""
