"""Black boxes: what learns a loop without a claim about its memory. Each is given the fitted half and nothing else."""
