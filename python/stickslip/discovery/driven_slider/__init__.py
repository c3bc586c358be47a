"""What the declared law of a slider driven by a known force lacks (`kind = "driven_slider"`).

`published` repeats the reference fits of the electro-mechanical positioning system (EMPS); `loop` finds what the
declared model lacks, in the likelihood of `stickslip.likelihoods.driven_slider`.
"""
