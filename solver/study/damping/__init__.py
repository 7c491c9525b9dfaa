"""What an impact loses, as a function of physical and numerical parameters; and its calibration."""
