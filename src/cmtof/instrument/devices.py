"""Simulated devices of the instrument, in process: the interfaces of `cmtof.hardware`'s drivers."""

TDAC_STEP = 20.0 / 2**14
"""Step of the LJTick-DAC, 14 bit, V."""
