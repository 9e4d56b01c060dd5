"""Law `ritz`: direct maximization of the Barber-Fabrikant functional."""
