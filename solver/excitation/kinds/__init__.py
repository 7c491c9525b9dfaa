"""The kinds of ground motion: the module `KIND` has `signal`, the motion along one direction."""
