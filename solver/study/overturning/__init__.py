"""Which pulses overturn a block: amplitude against frequency, all intervals of amplitude."""
