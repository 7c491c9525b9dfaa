"""Problems with closed forms, and what it takes to pose them: for tests and benchmarks."""
