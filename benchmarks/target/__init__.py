"""Exported arithmetic on microcontrollers: compiled for Cortex-M, run by qemu, instructions counted."""
