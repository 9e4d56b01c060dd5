"""Law `ellipse`: expansion about the optimal ellipse."""
