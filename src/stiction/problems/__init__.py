"""One contact problem on its own: read it, write it, solve it, and say how far off a solution is."""
