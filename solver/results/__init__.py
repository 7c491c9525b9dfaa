"""From a history to the numbers of a run."""
