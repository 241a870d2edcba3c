"""What is ours: the closed loop of the vehicle, its scenarios, metrics, figures and comparison."""
