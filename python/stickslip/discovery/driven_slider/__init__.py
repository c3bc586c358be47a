"""A slider driven by a known force: an inertia with friction and no spring (`kind = "driven_slider"`).

`published` repeats the reference fits of the electro-mechanical positioning system (EMPS); `loop` finds what the
declared model lacks. The equation of motion is

    mass x2' = F - damping x2 - T(x2) + effects,    F = drive, held from sample to sample,

with T the friction law of the model: `kinetic` for x2 < 0, `kinetic_plus` for x2 > 0.
"""
