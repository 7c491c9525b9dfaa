"""Up to when a history means something: runs beside twins that differ in their last digits."""
