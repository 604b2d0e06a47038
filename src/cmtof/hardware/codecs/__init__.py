"""Bytes and messages of each protocol, without input or output."""
