"""Real robots on a serial port, and virtual ones: protocols, an emulator, and driving."""
