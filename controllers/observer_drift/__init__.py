"""The observer, taught by a camera what no thermometer explains."""
