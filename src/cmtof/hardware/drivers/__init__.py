"""One thin driver a device."""
