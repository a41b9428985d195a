"""The steering law as a C99 project, and models in C for functional mock-up units."""
