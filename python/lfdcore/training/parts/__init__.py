"""What is learned on the way to a model: networks, hyper-parameters, noise, and the samples they are learned from."""
