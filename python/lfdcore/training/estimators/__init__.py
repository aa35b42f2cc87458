"""Models of the core for other frameworks: as a scikit-learn estimator, and in torch for a GPU."""
