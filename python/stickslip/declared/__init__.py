"""What is declared: rigs, friction laws, effects, units, and the model they make."""
