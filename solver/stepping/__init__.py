"""One step of all bodies in contact: residual, correction, impulses, energy ledger."""
