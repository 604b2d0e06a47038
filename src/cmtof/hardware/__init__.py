"""The instrument: transports, codecs, drivers, the rig, the scan, and a simulated twin."""
