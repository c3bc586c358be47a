"""The kinds of rigs, as `kind` in a table [rig] names them; the command line shows them before it loads anything."""

NAMED = ("two_degree", "block_on_belt", "driven_slider")
RIG_KINDS = (*NAMED, "bodies", "matrices")
