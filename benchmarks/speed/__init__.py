"""Parts of benchmarks/speed.py: what is measured, against what, how, and which limits must hold."""
