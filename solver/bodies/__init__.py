"""What moves: meshed bodies, rigid boxes, the oscillator."""
