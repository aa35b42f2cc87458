"""Training: whatever needs SciPy, scikit-learn or torch (the extra `train`). Nothing at run time imports it."""
