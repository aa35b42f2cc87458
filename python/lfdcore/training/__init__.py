"""Training that needs torch (extra `train`); what it makes runs without."""
