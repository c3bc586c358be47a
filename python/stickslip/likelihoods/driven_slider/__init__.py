"""A slider driven by a known force: an inertia with friction and no spring (`kind = "driven_slider"`).

Here is what a record says of the declared law, and of candidates beside it, in force noise of any colour; what joins
the law is decided in `stickslip.discovery.driven_slider`. The equation of motion is

    mass x2' = F - damping x2 - T(x2) + effects,    F = drive, held from sample to sample,

with T the friction law of the model: `kinetic` for x2 < 0, `kinetic_plus` for x2 > 0.
"""
