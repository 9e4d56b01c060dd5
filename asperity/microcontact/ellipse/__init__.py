"""Law `ellipse` of many summits at once: expansion about the optimal ellipse."""
