"""Bodies: meshed bodies, rigid boxes, the oscillator."""
