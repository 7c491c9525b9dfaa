"""Error against run time: one scene over ladders of steps and meshes."""
