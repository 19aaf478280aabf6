"""What a model still gets wrong, learnt from logs: slow lags of what drives the machine, weighted."""
