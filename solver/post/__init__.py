"""What is made of a run: its history, what the block did, its energy, fields and pictures."""
