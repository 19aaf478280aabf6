"""Where the runs of a study are computed: on the cores of this machine, or on a Dask cluster."""
